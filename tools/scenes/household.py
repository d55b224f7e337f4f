"""Small things of a household: cloths, pictures, books, clothes. `furniture.py` defines what a piece is."""

import numpy as np

from forms import pipe, sheet, surface
from shapes import bars, box, curve, flat, joined, lathe, moved, prism, quad, rounded, turned


def blind(width, height, pitch, slat, tilt):
    """Slats from y = 0 up, each a little bowed, tilted by `tilt` degrees, front edges low."""
    t = np.linspace(-1, 1, 5)
    top = np.stack([t * slat / 2, 0.09 * slat * (1 - t**2)], 1)  # z, y
    outline = np.concatenate([top, top[::-1] - (0, 0.0012)])
    c, s = np.cos(np.radians(tilt)), np.sin(np.radians(tilt))
    z, y = outline[:, 0] * c + outline[:, 1] * s, -outline[:, 0] * s + outline[:, 1] * c
    one = turned(prism(np.stack([y, -z], 1), -width / 2, width / 2), 90, (0, 0, 1))  # along x, no longer along y
    count = int((height - 0.06) / pitch)
    slats = flat(*(moved(one, (0, 0.03 + pitch * (i + 0.5), 0)) for i in range(count)))
    rails = bars((-width / 2, width / 2, 0, 0.025, -slat / 2, slat / 2),
                 (-width / 2, width / 2, height - 0.035, height, -slat / 2 - 0.005, slat / 2 + 0.005))
    return dict(slats=slats, rails=rails)


def curtain(width, height, folds, depth=0.06, seed=0, gather=0.0):
    """Hangs from y = `height` to the floor over `width` in even folds; `gather` draws its middle together as a tie
    does."""
    rng = np.random.default_rng(seed)
    phase, wobble = rng.uniform(0, 6), rng.uniform(-0.25, 0.25, 4)

    def point(s, t):
        bend = s + 0.05 * sum(w * np.sin((k + 1) * np.pi * s) for k, w in enumerate(wobble))
        fold = np.sin(2 * np.pi * folds * bend + phase + 0.5 * t * np.sin(5 * s + phase))
        narrow = 1 - gather * np.exp(-((t - 0.6) / 0.22) ** 2)
        x = (s - 0.5) * width * narrow + 0.12 * depth * np.sin(9 * bend + 2 * t)
        return x, height * (1 - t), depth * (0.35 + 0.65 * np.minimum(1, 0.3 + t)) * fold * (0.5 + 0.5 * narrow)

    return dict(cloth=surface(point, 10 * folds, 14))


def drape(width, height, folds=5, swell=0.06, rows=24, columns=60, gather=0.0, seed=0):
    """A cloth that hangs down from its top edge, along x at y = 0, in folds that grow; to be worn doubleSided. `gather`
    draws its foot in. Where `curtain` is a piece for a window, this is any cloth."""
    rng = np.random.default_rng(seed)
    s, t = np.meshgrid(np.linspace(0, 1, rows + 1), np.linspace(0, 1, columns + 1), indexing="ij")
    phase = rng.random(3) * 6.28
    deep = 0.35 + 0.65 * np.sqrt(s)
    z = swell * deep * (np.sin(2 * np.pi * folds * t + phase[0] + 0.8 * s)
                        + 0.35 * np.sin(2 * np.pi * folds * 2.3 * t + phase[1] - 1.3 * s))
    x = (t - 0.5) * width * (1 - gather * np.sin(np.pi * np.clip(s * 1.15, 0, 1)) ** 2)
    y = -height * s - 0.02 * height * s * np.sin(2 * np.pi * 1.5 * t + phase[2])
    return sheet(np.stack([x, y, z], 2), uvs=np.stack([t, s * height / width], 2))


def rug(width, depth, thick):
    """Lies about the origin, a hair's breadth above the floor; one picture covers it."""
    m = box((-width / 2, 0.0005, -depth / 2), (width / 2, thick, depth / 2))
    m["uvs"] = (m["positions"][:, [0, 2]] / (width, depth) + 0.5).astype(np.float32)
    return m


def picture(width, height, rim=0.03, mat=0.0, depth=0.022):
    """A framed picture about the origin that hangs on the plane z = 0."""
    w, h = width / 2, height / 2
    inside = (w - rim, h - rim)
    frame = bars((-w, w, h - rim, h, 0.001, depth), (-w, w, -h, rim - h, 0.001, depth),
                 (-w, rim - w, rim - h, h - rim, 0.001, depth), (w - rim, w, rim - h, h - rim, 0.001, depth))
    x, y = inside[0] - mat, inside[1] - mat
    piece = dict(frame=frame, print=quad((-x, -y, 0.011), (2 * x, 0, 0), (0, 2 * y, 0)))
    if mat:
        piece["mat"] = flat(box((-inside[0], -inside[1], 0.002), (inside[0], inside[1], 0.009)))
    return piece


def pillow(width, depth, thick):
    """Lies about the origin; its corners are drawn out and a head has dented it. `forms.cushion` is a plain one."""
    def half(way):
        def point(s, t):
            u, v = 2 * s - 1, 2 * t - 1
            swell = (np.clip((1 - u**2) * (1 - v**2), 0, 1)) ** 0.38
            pinch = 1 - 0.09 * (1 - v**2), 1 - 0.09 * (1 - u**2)
            dent = 1 - 0.12 * np.exp(-((u - 0.1) ** 2 + v**2) * 5)
            x, z = u * pinch[0] * width / 2, way * v * pinch[1] * depth / 2
            return x, thick * (0.5 + way * 0.5 * swell * (dent if way > 0 else 1)), z
        return surface(point, 18, 14)
    return joined(half(1), half(-1))


def covers(m, *names):
    """What rows and piles of books wear, of a scene's materials."""
    return {f"cloth {i}": m[name] for i, name in enumerate(names)} | dict(pages=m["pages"])


def book(thick, height, depth):
    """Upright, its spine at z = 0 towards +z: cloth boards about a paler block of pages."""
    t, round_ = thick / 2, 0.25 * thick
    spine = [(t * np.cos(a), round_ * (np.sin(a) - 1)) for a in np.linspace(np.pi, 0, 5)]
    boards = [prism(spine, 0, height)]
    skin = min(0.0025, 0.2 * thick)
    boards += [box((-t, 0, -depth), (-t + skin, height, -round_)), box((t - skin, 0, -depth), (t, height, -round_))]
    return flat(*boards), flat(box((-t + skin, 0.003, 0.004 - depth), (t - skin, height - 0.004, -round_)))


def books(length, height, depth, rng, colours, fill=0.85):
    """A row from x = 0 on, upright, a few of them leaning at its end; cloth by colour, and the pages."""
    piece, x = {}, 0.0
    while x < length * fill:
        thick = rng.uniform(0.014, 0.05)
        size = (thick, height * rng.uniform(0.68, 0.95), depth * rng.uniform(0.7, 0.92))
        x += thick / 2
        if x + thick / 2 > length:
            break
        cloth, pages = book(*size)
        at = (x, 0, depth * rng.uniform(0.93, 0.99))
        x += thick / 2 + rng.uniform(0.0003, 0.002)
        piece.setdefault(f"cloth {rng.integers(colours)}", []).append(moved(cloth, at))
        piece.setdefault("pages", []).append(moved(pages, at))
    lean, cloth_pages = rng.uniform(9, 16), book(0.025, height * 0.8, depth * 0.8)
    if x + 0.025 + height * 0.8 * np.sin(np.radians(lean)) < length:
        for key, m in zip((f"cloth {rng.integers(colours)}", "pages"), cloth_pages):
            tilted = turned(moved(m, (0.0125, 0, 0)), lean, (0, 0, 1))
            foot = height * 0.8 * np.sin(np.radians(lean))
            piece.setdefault(key, []).append(moved(tilted, (x + foot, 0, 0.95 * depth)))
    return {key: flat(*parts) for key, parts in piece.items()}


def book_pile(count, rng, colours):
    """Books that lie on each other, about the origin."""
    piece, y = {}, 0.0
    for _ in range(count):
        thick = rng.uniform(0.016, 0.04)
        size = (thick, rng.uniform(0.18, 0.25), rng.uniform(0.13, 0.18))
        turn = rng.uniform(-14, 14)
        for key, m in zip((f"cloth {rng.integers(colours)}", "pages"), book(*size)):
            lying = turned(moved(m, (0, -size[1] / 2, size[2] / 2)), 90, (0, 0, 1))
            piece.setdefault(key, []).append(moved(lying, (0, y + thick / 2, 0), turn))
        y += thick
    return {key: flat(*parts) for key, parts in piece.items()}


def coat(rng, length=1.0):
    """Hangs from a hook at the origin, in front of the plane z = 0."""
    folds = rng.uniform(0, 6, 3)
    shape = curve([(0.02, 0.0), (0.12, 0.05), (0.2, 0.12), (0.2, 0.4), (0.22, 0.7), (0.26, 1.0)], 3)

    def point(s, t):
        radius = np.interp(t, shape[:, 1], shape[:, 0])
        angle = -2 * np.pi * s
        ripple = 1 + 0.16 * t * np.sin(6 * angle + folds[0]) + 0.07 * t * np.sin(11 * angle + folds[1] + 2 * t)
        return radius * np.cos(angle) * ripple, -length * t, 0.1 + 0.42 * radius * np.sin(angle) * ripple
    body = surface(point, 36, 18)
    sleeves = [pipe(curve([(side * 0.15, -0.13, 0.1), (side * 0.235, -0.25, 0.12), (side * 0.245, -0.48, 0.15),
                           (side * 0.23, -0.68, 0.16)], 3), np.linspace(0.055, 0.062, 10), 12) for side in (-1, 1)]
    return flat(body), flat(*sleeves)


def shoe(length=0.27):
    """A low shoe about the origin, its toe towards +z."""
    def point(s, t):
        z = length * (t - 0.5)
        wide = 0.042 * (1 - 0.2 * np.cos(3 * np.pi * t)) * np.sqrt(np.clip(1 - (2 * t - 1) ** 8, 0.0004, 1))
        high = np.interp(t, [0, 0.1, 0.35, 0.55, 0.85, 1], [0.06, 0.085, 0.08, 0.06, 0.045, 0.02])
        angle = np.pi * (1 - s)
        return wide * np.sign(np.cos(angle)) * np.abs(np.cos(angle)) ** 0.6, high * np.sin(angle) ** 0.6, z + 0 * s
    return surface(point, 12, 16)


def umbrella(length=0.85):
    """Furled, upright, its crook above."""
    cloth = lathe(curve([(0.004, 0.08), (0.028, 0.2), (0.034, 0.45), (0.02, 0.68), (0.01, 0.72)], 3), segments=14)
    crook = [(0, 0, 0), (0, length, 0), (0.01, length + 0.04, 0), (0.04, length + 0.06, 0), (0.07, length + 0.04, 0),
             (0.08, length, 0)]
    return dict(cloth=cloth, wood=pipe(curve(crook, 3), 0.007, 8))


def radiator(length=0.9, height=0.6):
    """Ribs on a wall at z = 0."""
    count = int(length / 0.06)
    ribs = [rounded((x - 0.023, 0.1, 0.03), (x + 0.023, height, 0.13), 0.02, 1)
            for x in (np.arange(count) - (count - 1) / 2) * 0.06]
    ends = [pipe([(-length / 2 + 0.02, y, 0.08), (length / 2 - 0.02, y, 0.08)], 0.02, 8) for y in (0.15, height - 0.06)]
    return dict(metal=flat(*ribs, *ends, box((length / 2 - 0.05, 0, 0.07), (length / 2 - 0.03, 0.15, 0.09))))
