"""Pieces that our scenes share. A piece is a dict of meshes by what they are made of, for `glb.place`; it stands on
y = 0 about x = 0, its back at or about z = 0 where it has one, and faces +z. Lengths in metres."""

import numpy as np

from forms import pipe, surface
from shapes import box, creased, curve, flat, joined, lathe, mesh, moved, prism, quad, rounded, sphere, turned, wall


def bars(*corners):
    """Boxes given as (x0, x1, y0, y1, z0, z1)."""
    return flat(*(box(c[::2], c[1::2]) for c in corners))


def disc(radius, height, segments=16, up=True):
    """A round face that looks up, or down."""
    line = [(radius, height), (0.0, height)]
    return lathe(line if up else line[::-1], segments=segments)


def shell(outside, thickness, segments=32):
    """A thin round wall with both its sides and rims: `outside` is its smooth profile, upwards."""
    line = np.asarray(outside, float)
    inside = line[::-1] - (thickness, 0)
    return lathe(line, [line[-1], inside[0]], inside, [inside[-1], line[0]], segments=segments)


def shade(outside, thickness=0.004, segments=32):
    """A lamp's opaque shade, open above and below: its cloth outside, its lining within and on the rims."""
    line = np.asarray(outside, float)
    inside = line[::-1] - (thickness, 0)
    return dict(shade=lathe(line, segments=segments), lining=lathe(
        [line[-1], inside[0]], inside, [inside[-1], line[0]], segments=segments))


def vase(profile, segments=32, thick=0.006):
    """A vessel, open above, whose outside goes through `profile` from its foot to its lip."""
    line = curve(profile, 3)
    inside = [(max(r - thick, 0.001), max(h, line[0, 1] + thick)) for r, h in line[::-1]]
    floor = (0.0, inside[-1][1])
    return lathe([(0.0, line[0, 1]), line[0]], line, [line[-1], inside[0]], [*inside, floor], segments=segments)


# Walls

def door_leaf(width=0.86, height=2.03, thick=0.04):
    """A door with four sunk panels, from its hinge at the origin along +x; both its sides are alike."""
    frame, sunk, middle, half = 0.12, 0.012, 0.95, thick / 2
    columns, rows = (0, frame, width / 2 - 0.05, width / 2 + 0.05, width - frame, width), (0, 0.2, middle, 1.08)
    rows = (*rows, height - frame, height)
    parts = [(columns[i], columns[i + 1], 0, height, -half, half) for i in (0, 2, 4)]
    for i in (1, 3):
        parts += [(columns[i], columns[i + 1], rows[j], rows[j + 1], -half, half) for j in (0, 2, 4)]
        for j in (1, 3):
            parts.append((columns[i], columns[i + 1], rows[j], rows[j + 1], sunk - half, half - sunk))
            edge = 0.05
            parts.append((columns[i] + edge, columns[i + 1] - edge, rows[j] + edge, rows[j + 1] - edge, -half + 0.004,
                          half - 0.004))
    handle = []
    for side in (1, -1):
        out = half + 0.05
        lever = [(width - 0.06, 1.02, side * half), (width - 0.06, 1.02, side * (out - 0.01)),
                 (width - 0.075, 1.02, side * out), (width - 0.17, 1.015, side * out)]
        handle.append(pipe(curve(lever, 3), 0.009))
        plate = (width - 0.085, width - 0.035, 0.92, 1.1, side * half, side * (half + 0.006))
        handle.append(box(np.minimum(plate[::2], plate[1::2]), np.maximum(plate[::2], plate[1::2])))
    return dict(door=bars(*parts), metal=flat(*handle))


def door_frame(width=0.88, height=2.05, depth=0.12, casing=0.09):
    """The lining and casings of an opening from x = 0 in a wall whose front is z = 0."""
    lining, proud, back = 0.02, 0.018, -depth
    parts = [(-0.001, lining, 0, height - lining, back, 0),
             (width - lining, width + 0.001, 0, height - lining, back, 0),
             (-0.001, width + 0.001, height - lining, height + 0.001, back, 0)]
    for front, rear in ((proud, 0.0), (back, back - proud)):
        parts += [(-casing, 0.008, 0, height + casing, rear, front),
                  (width - 0.008, width + casing, 0, height + casing, rear, front),
                  (0.008, width - 0.008, height - 0.008, height + casing, rear, front)]
    return dict(frame=bars(*parts))


def room(x0, x1, z0, z1, height, thick=0.12, **openings):
    """Walls around, fronts inside, floor and ceiling apart. `openings` by side: (low, high, bottom, top) each, in x or
    in z; a side that is None is left out. The walls go past the corners and beyond floor and ceiling, so that no
    light leaks."""
    across, along, above = x1 - x0 + 2 * thick, z1 - z0 + 2 * thick, height + 0.08
    sides = dict(  # length, the place of the wall's own x = 0, its turn, and how x or z becomes its own x
        back=(across, (x0 - thick, 0, z0), 0, lambda a, b: (a - x0 + thick, b - x0 + thick)),
        front=(across, (x1 + thick, 0, z1), 180, lambda a, b: (x1 + thick - b, x1 + thick - a)),
        left=(along, (x0, 0, z1 + thick), 90, lambda a, b: (z1 + thick - b, z1 + thick - a)),
        right=(along, (x1, 0, z0 - thick), -90, lambda a, b: (a - z0 + thick, b - z0 + thick)))
    piece = {}
    for side, (length, at, turn, own) in sides.items():
        holes = openings.get(side, ())
        if holes is not None:
            holes = [(*own(a, b), low, high) for a, b, low, high in holes]
            piece[side] = moved(wall(length, above, thick, holes, below=0.08), at, turn)
    return piece


def skirting(length, height=0.09, openings=()):
    """A board along the foot of a wall along +x, front at +z; `openings` are (left, right)."""
    ends = [0, *(x for pair in sorted(openings) for x in pair), length]
    return bars(*((a, b, 0, height, -0.005, 0.015) for a, b in zip(ends[::2], ends[1::2]) if b > a))


def wainscot(length, height=0.95, openings=(), every=0.62):
    """Panelling along the foot of a wall along +x: boards, sunk panels by their frames, a rail on top."""
    ends = [0, *(x for pair in sorted(openings) for x in pair), length]
    parts = []
    for a, b in zip(ends[::2], ends[1::2]):
        if b - a < 0.02:
            continue
        parts += [(a, b, 0, height, -0.005, 0.012), (a, b, 0, 0.14, 0.012, 0.026),
                  (a, b, height - 0.09, height, 0.012, 0.02),
                  (a, b, height, height + 0.025, -0.005, 0.04)]
        edges = np.linspace(a, b, max(1, round((b - a) / every)) + 1)
        parts += [(max(a, x - 0.045), min(b, x + 0.045), 0.14, height - 0.09, 0.012, 0.02) for x in edges]
        parts += [(x + 0.09, y - 0.09, 0.21, height - 0.15, 0.012, 0.017)
                  for x, y in zip(edges, edges[1:]) if y - x > 0.25]
    return bars(*parts)


def window_frame(width, height, depth=0.12, bar=0.05, columns=2, rows=2):
    """Lining, sashes and bars of an opening from the origin in a wall whose front is z = 0, without panes."""
    parts = [(0, bar, 0, height, -depth, -0.02), (width - bar, width, 0, height, -depth, -0.02),
             (bar, width - bar, 0, bar, -depth, -0.02), (bar, width - bar, height - bar, height, -depth, -0.02)]
    for i in range(1, columns):
        x = width * i / columns
        parts.append((x - bar / 2, x + bar / 2, bar, height - bar, -0.8 * depth, -0.4 * depth))
    for j in range(1, rows):
        y = height * j / rows
        parts.append((bar, width - bar, y - bar / 4, y + bar / 4, -0.75 * depth, -0.45 * depth))
    return dict(frame=bars(*parts))


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
    """Hangs from y = `height` to the floor over `width`; `gather` draws its middle together as a tie does."""
    rng = np.random.default_rng(seed)
    phase, wobble = rng.uniform(0, 6), rng.uniform(-0.25, 0.25, 4)

    def point(s, t):
        bend = s + 0.05 * sum(w * np.sin((k + 1) * np.pi * s) for k, w in enumerate(wobble))
        fold = np.sin(2 * np.pi * folds * bend + phase + 0.5 * t * np.sin(5 * s + phase))
        narrow = 1 - gather * np.exp(-((t - 0.6) / 0.22) ** 2)
        x = (s - 0.5) * width * narrow + 0.12 * depth * np.sin(9 * bend + 2 * t)
        return x, height * (1 - t), depth * (0.35 + 0.65 * np.minimum(1, 0.3 + t)) * fold * (0.5 + 0.5 * narrow)

    return dict(cloth=surface(point, 10 * folds, 14))


# Furniture

def chair(width=0.44, depth=0.44, back=0.92):
    """A dining chair: splayed back, four rungs, a padded seat. It stands about the origin."""
    w, d, seat = width / 2, depth / 2, 0.44
    legs = []
    for side in (-1, 1):
        x = side * (w - 0.02)
        legs.append(pipe([(x * 1.02, 0, d - 0.01), (x, seat, d - 0.03)], (0.014, 0.02), 8))
        legs.append(pipe(curve([(x, 0, -d - 0.05), (x, 0.3, -d + 0.015), (x, seat, -d + 0.02), (x, 0.68, -d - 0.01),
                                (x, back, -d - 0.09)], 2), np.linspace(0.015, 0.016, 9), 8))
        legs.append(pipe([(x, 0.2, d - 0.02), (x, 0.2, -d + 0.005)], 0.009, 6))
    z = lambda y: -d - 0.01 - 0.08 * ((y - 0.68) / 0.24) ** 1.2 if y > 0.68 else -d + 0.005
    for y in (0.24, 0.88, 0.62):
        thick, high = (0.012, 0.03) if y > 0.3 else (0.009, 0.009)
        legs.append(moved(rounded((-w + 0.02, -high, -thick), (w - 0.02, high, thick), 0.006), (0, y, z(y))))
    for x in np.linspace(-0.6, 0.6, 5) * (w - 0.02):
        legs.append(pipe([(x, 0.63, z(0.63)), (x, 0.75, z(0.75) + 0.004), (x, 0.86, z(0.86))], 0.007, 6))
    apron = box((-w + 0.015, seat - 0.05, -d + 0.01), (w - 0.015, seat, d - 0.02))
    return dict(wood=flat(apron, *legs), seat=rounded((-w, seat - 0.005, -d), (w, seat + 0.04, d), 0.018, 2))


def table(width, depth, height=0.75, leg=0.07, overhang=0.05):
    """A table about the origin; its top is apart, with texture coordinates in metres."""
    w, d, top = width / 2, depth / 2, 0.032
    x, z = w - overhang, d - overhang
    legs = []
    for sx in (-1, 1):
        for sz in (-1, 1):
            outline = [(sx * x, sz * z), (sx * x, sz * (z - leg)), (sx * (x - leg), sz * (z - leg)),
                       (sx * (x - leg), sz * z)]
            square = prism(outline[::sx * sz], 0, height - top)
            square["positions"][square["positions"][:, 1] == 0] *= (0.985, 1, 0.97)
            legs.append(square)
    x, z, low, high = x - 0.01, z - 0.01, height - top - 0.09, height - top
    apron = bars((-x, x, low, high, z - 0.02, z), (-x, x, low, high, -z, -z + 0.02),
                 (x - 0.02, x, low, high, -z, z), (-x, -x + 0.02, low, high, -z, z))
    return dict(wood=flat(apron, *legs), top=box((-w, high, -d), (w, height, d)))


def knob(radius=0.014, segments=10):
    """A knob that sticks out along +z from the origin."""
    line = [(radius * 0.45, 0), (radius * 0.45, radius * 0.9), (radius, radius * 1.2), (radius * 0.8, radius * 1.9)]
    return flat(turned(lathe([*line, (0, radius * 2.1)], segments=segments), 90))


def bar_handle(length, upright=True):
    """A round bar on two posts, out along +z from its middle at the origin."""
    ends = [pipe([(0, y, 0), (0, y, 0.03)], 0.004, 6) for y in (-0.4 * length, 0.4 * length)]
    rod = pipe([(0, -length / 2, 0.03), (0, length / 2, 0.03)], 0.0055, 8)
    handle = joined(rod, *ends)
    return handle if upright else turned(handle, 90, (0, 0, 1))


def cabinet(width, height, depth, columns, rows, legs=0.12, bar=0.0, frame=0.05):
    """A closed body with `columns` of doors or drawers; `rows` are shares of the height, from above. Framed fronts
    with knobs, or with bars of length `bar`."""
    w, gap, front = width / 2, 0.003, depth
    body = [(-w, w, legs, height, 0, depth - 0.002)]
    if legs:
        body += [(x, x + 0.04, 0, legs, z, z + 0.04) for x in (-w + 0.02, w - 0.06) for z in (0.02, depth - 0.06)]
    fronts, grips = [], []
    shares = np.concatenate([[0], np.cumsum(rows) / np.sum(rows)])
    inner = (legs + 0.02, height - 0.025)
    for i in range(columns):
        x0, x1 = (-w + 0.015 + (width - 0.03) * (i + k) / columns for k in (0, 1))
        for high, low in zip(shares, shares[1:]):
            y1, y0 = (inner[1] - (inner[1] - inner[0]) * s for s in (high, low))
            a, b, c, d = x0 + gap, x1 - gap, y0 + gap, y1 - gap
            fronts += [(a, b, c, d, front - 0.002, front + 0.008),
                       (a, a + frame, c, d, front + 0.008, front + 0.018),
                       (b - frame, b, c, d, front + 0.008, front + 0.018),
                       (a + frame, b - frame, c, c + frame, front + 0.008, front + 0.018),
                       (a + frame, b - frame, d - frame, d, front + 0.008, front + 0.018)]
            door = d - c > 0.3
            at = (b - frame / 2 if i % 2 == 0 else a + frame / 2, (c + d) / 2) if door else ((a + b) / 2, d - frame / 2)
            grip = flat(bar_handle(min(bar, 0.5 * (b - a)) if not door else bar, door)) if bar else knob()
            grips.append(moved(grip, (*at, front + 0.018)))
    return dict(body=bars(*body), fronts=bars(*fronts), metal=flat(*grips),
                top=box((-w - 0.015, height, 0), (w + 0.015, height + 0.025, depth + 0.03)))


def shelf(width, height, depth, boards, thick=0.022):
    """An open bookcase; also the height of each board that things can stand on."""
    w = width / 2
    levels = np.linspace(0.07, height - thick, boards + 1)
    parts = [(-w, -w + thick, 0, height, 0, depth), (w - thick, w, 0, height, 0, depth),
             (-w + thick, w - thick, 0.0, height, 0, 0.008),
             (-w + thick, w - thick, 0, 0.07 - thick, 0.03, depth - 0.02)]
    parts += [(-w + thick, w - thick, y - (thick if i == 0 else 0), y + (thick if i else 0), 0.008, depth - 0.002)
              for i, y in enumerate(levels)]
    return dict(wood=bars(*parts)), [y + (thick if i else 0) for i, y in enumerate(levels[:-1])]


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


def armchair(width=0.82, depth=0.8):
    """An upholstered chair, its back to -z, about the origin."""
    w, d = width / 2, depth / 2
    arm = 0.16
    cloth = [rounded((-w + arm, 0.14, -d + 0.1), (w - arm, 0.3, d - 0.02), 0.03, 1),
             rounded((-w, 0.12, -d + 0.06), (-w + arm, 0.6, d - 0.03), 0.06, 2),
             rounded((w - arm, 0.12, -d + 0.06), (w, 0.6, d - 0.03), 0.06, 2),
             turned(rounded((-w + 0.02, 0.12, -0.09), (w - 0.02, 0.9, 0.09), 0.07, 2), -8)]
    cloth[3] = moved(cloth[3], (0, 0, -d + 0.14))
    pad = [rounded((-w + arm + 0.01, 0.29, -d + 0.2), (w - arm - 0.01, 0.43, d), 0.05, 2),
           moved(turned(rounded((-0.22, 0, -0.07), (0.22, 0.38, 0.07), 0.06, 2), -14), (0, 0.42, -d + 0.29))]
    feet = [pipe([(sx * (w - 0.08), 0, sz * (d - 0.1)), (sx * (w - 0.1), 0.14, sz * (d - 0.12))], (0.014, 0.024), 8)
            for sx in (-1, 1) for sz in (-1, 1)]
    return dict(cloth=joined(*cloth), pad=joined(*pad), wood=flat(*feet))


def pillow(width, depth, thick):
    """Lies about the origin; its corners are drawn out."""
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


# Lamps

def table_lamp(height=0.42, radius=0.14, bulb=0.03):
    """A turned foot and an opaque shade, open above and below; the bulb in it shines."""
    foot = curve([(0.07, 0.0), (0.072, 0.012), (0.03, 0.03), (0.022, 0.05), (0.05, 0.1), (0.058, 0.14), (0.03, 0.2),
                  (0.014, 0.23), (0.01, height - 0.1)], 3)
    low, high = height - 0.17, height
    return dict(foot=lathe([(0, 0), (0.07, 0)], foot, [(0.01, height - 0.1), (0, height - 0.1)], segments=24),
                **shade([(radius, low), (0.68 * radius, high)]),
                bulb=moved(sphere(bulb, 1), (0, height - 0.1 + bulb, 0)))


def uplighter(height=1.75):
    """A standing lamp whose opaque bowl sends all of its light to the ceiling."""
    foot = creased([(0, 0), (0.15, 0), (0.15, 0.015), (0.02, 0.03), (0.014, 0.04), (0.012, height - 0.1)], 20)
    bowl = curve([(0.03, height - 0.1), (0.09, height - 0.08), (0.15, height - 0.03), (0.18, height + 0.03)], 3)
    inside = [(r - 0.005, h + 0.004) for r, h in bowl[::-1]]
    parts = lathe([(0.0, height - 0.1), bowl[0]], bowl, [bowl[-1], inside[0]], [*inside, (0.0, inside[-1][1])])
    return dict(foot=foot, bowl=parts, bulb=disc(0.11, height - 0.03, 12))


def pendant(drop, radius=0.2, height=0.22):
    """Hangs `drop` from y = 0: an opaque drum, open above and below; discs in its middle shine up and down."""
    low, high = -drop, height - drop
    middle = (low + high) / 2
    rod = pipe([(0, 0, 0), (0, middle, 0)], 0.005, 6)
    rose = creased([(0.0, -0.03), (0.05, -0.025), (0.055, 0.0)], 16)
    arms = [pipe([(0, middle, 0), (x, middle, z)], 0.004, 5) for x, z in
            np.array([(np.cos(a), np.sin(a)) for a in (0, 2.1, 4.2)]) * (radius - 0.002)]
    up, down = disc(0.6 * radius, middle + 0.012, 16), disc(0.6 * radius, middle - 0.012, 16, up=False)
    rim = shell([(0.6 * radius + 0.002, middle - 0.015), (0.6 * radius + 0.002, middle + 0.015)], 0.002, 16)
    return dict(metal=flat(rod, rose, rim, *arms), **shade([(radius, low), (radius, high)]), bulb=joined(up, down))


def dome(drop, radius=0.18, height=0.16):
    """Hangs `drop` from y = 0: an opaque dome, open below, its light high inside."""
    low, high = -drop, height - drop
    line = curve([(radius, low), (0.93 * radius, low + 0.35 * height), (0.6 * radius, low + 0.8 * height),
                  (0.2 * radius, high)], 3)
    inside = line[::-1] - (0.004, 0.004)
    rod = pipe([(0, 0, 0), (0, high - 0.005, 0)], 0.004, 6)
    cap = creased([(0.2 * radius, high - 0.01), (0.15 * radius, high + 0.04), (0, high + 0.045)], 16)
    rose = creased([(0.0, -0.025), (0.045, -0.02), (0.05, 0.0)], 16)
    return dict(rod=flat(rod, rose), cap=cap, shade=lathe(line, [line[-1], (0, high)], segments=40),
                inside=lathe([(0.0, inside[0, 1]), inside[0]], inside, [inside[-1], line[0]], segments=40),
                bulb=disc(0.4 * radius, low + 0.55 * height, 16, up=False))


def sconce(width=0.2, height=0.14, depth=0.1):
    """A half-round shade on a wall, open above and below, about its bulb."""
    def side(scale, way):
        def point(s, t):
            a = np.pi * (1 - s) if way > 0 else np.pi * s
            return scale * width / 2 * np.cos(a), height * (1 - t), scale * depth * np.sin(a)
        return surface(point, 16, 1)
    rims = []
    for y, way in ((0.0, -1), (height, 1)):
        rims.append(surface(lambda s, t, y=y, way=way: (
            (1 - 0.06 * t) * -way * width / 2 * -np.cos(np.pi * s), y + 0 * s,
            (1 - 0.06 * t) * depth * np.sin(np.pi * s)),
            16, 1))
    plate = flat(box((-0.03, 0.02, 0.0), (0.03, height - 0.02, 0.02)))
    bulb = moved(sphere(0.022, 1), (0, height / 2, 0.05))
    return dict(shade=joined(side(1.0, 1), side(0.94, -1), *rims), metal=plate, bulb=bulb)


# Things

def teapot(scale=1.0):
    """Stands about the origin, its spout towards +x; the body alone is about 0.12 high."""
    body = curve([(0.045, 0.0), (0.075, 0.025), (0.085, 0.055), (0.072, 0.09), (0.042, 0.108)], 4)
    lid = curve([(0.044, 0.108), (0.036, 0.117), (0.016, 0.125), (0.007, 0.13), (0.013, 0.139), (0.009, 0.148),
                 (0.0, 0.15)], 3)
    pot = lathe([(0, 0), body[0]], body, [body[-1], lid[0]], lid, segments=32)
    spout = pipe(curve([(0.06, 0.04, 0), (0.1, 0.052, 0), (0.118, 0.085, 0), (0.145, 0.108, 0)], 4),
                 np.linspace(0.02, 0.009, 13), 12)
    handle = pipe(curve([(-0.068, 0.092, 0), (-0.11, 0.1, 0), (-0.132, 0.072, 0), (-0.115, 0.042, 0),
                         (-0.078, 0.032, 0)], 4), 0.0075, 10)
    for m in (spout, handle):
        m["uvs"] = np.zeros((len(m["positions"]), 2), np.float32)
    return moved(joined(pot, spout, handle), scale=scale)


def plant(rng, leaves=26, size=0.3, pot=(0.11, 0.2)):
    """A pot with a spray of long leaves, to be seen from both sides."""
    radius, height = pot
    piece = dict(pot=lathe([(0, 0), (0.72 * radius, 0)], [(0.72 * radius, 0), (radius, height)],
                           [(radius, height), (radius - 0.012, height)],
                           [(radius - 0.012, height), (radius - 0.016, height - 0.03)], segments=24),
                 earth=disc(radius - 0.014, height - 0.02, 16))
    parts = []
    for i in range(leaves):
        turn, rise, long_ = i * 137.5, rng.uniform(0.25, 1.25), size * rng.uniform(0.7, 1.3)

        def point(s, t, rise=rise, long_=long_):
            wide = 0.11 * long_ * np.sin(np.pi * (0.08 + 0.9 * t)) ** 0.8
            out = long_ * (t * np.cos(rise) + 0.25 * t**2)
            up = long_ * (1.1 * t * np.sin(rise) + 0.35 * t - 0.75 * t**2 * np.cos(rise))
            return (2 * s - 1) * wide, up + 0.25 * wide * np.abs(2 * s - 1), 0.012 + out
        parts.append(moved(surface(point, 2, 7), (0, height - 0.025, 0), turn))
    return {**piece, "leaves": joined(*parts)}


def plate(radius=0.135):
    """A dinner plate."""
    under = [(0.0, 0.0), (0.6 * radius, 0.0)], curve([(0.6 * radius, 0.0), (0.7 * radius, 0.006), (radius, 0.02)], 2)
    rim = [(radius, 0.02), (radius - 0.002, 0.023)]
    above = curve([(radius - 0.002, 0.023), (0.72 * radius, 0.011), (0.62 * radius, 0.005), (0.0, 0.005)], 2)
    return lathe(*under, rim, above, segments=28)


def bowl(radius=0.08, height=0.055):
    return vase([(0.4 * radius, 0.0), (0.75 * radius, 0.25 * height), (0.95 * radius, 0.65 * height), (radius, height)],
                24, 0.004)


def mug(radius=0.04, height=0.09):
    handle = pipe(curve([(radius - 0.004, 0.78 * height, 0), (radius + 0.022, 0.72 * height, 0),
                         (radius + 0.024, 0.4 * height, 0), (radius - 0.004, 0.25 * height, 0)], 3), 0.005, 8)
    handle["uvs"] = np.zeros((len(handle["positions"]), 2), np.float32)
    body = creased([(0, 0), (radius, 0), (radius, height), (radius - 0.004, height), (radius - 0.004, 0.006),
                    (0, 0.006)],
                   28)
    return joined(body, handle)


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


def shoe(length=0.27):
    """A low shoe about the origin, its toe towards +z."""
    def point(s, t):
        z = length * (t - 0.5)
        wide = 0.042 * (1 - 0.2 * np.cos(3 * np.pi * t)) * np.sqrt(np.clip(1 - (2 * t - 1) ** 8, 0.0004, 1))
        high = np.interp(t, [0, 0.1, 0.35, 0.55, 0.85, 1], [0.06, 0.085, 0.08, 0.06, 0.045, 0.02])
        angle = np.pi * (1 - s)
        return wide * np.sign(np.cos(angle)) * np.abs(np.cos(angle)) ** 0.6, high * np.sin(angle) ** 0.6, z + 0 * s
    return surface(point, 12, 16)


def pot(radius=0.11, height=0.13, long_handle=False):
    """A cooking pot with its lid; two ears, or one long handle towards +x."""
    body = creased([(0, 0), (radius, 0), (radius, height), (radius + 0.004, height), (radius + 0.004, height + 0.004),
                    (radius - 0.003, height + 0.004)], 40)
    r = radius + 0.001
    lid = lathe(curve([(r, height + 0.004), (0.8 * r, height + 0.016), (0.3 * r, height + 0.024), (0, height + 0.025)],
                      3))
    grip = moved(lathe(curve([(0.008, 0), (0.007, 0.012), (0.02, 0.02), (0.016, 0.03), (0, 0.032)], 2), segments=16),
                 (0, height + 0.022, 0))
    high = 0.8 * height
    if long_handle:
        ears = [pipe([(radius - 0.003, high, 0), (radius + 0.05, high + 0.01, 0), (radius + 0.2, high + 0.03, 0)],
                     (0.007, 0.008, 0.01), 10)]
    else:
        ears = [pipe(curve([(x * radius * 0.99, high, -0.03), (x * (radius + 0.035), high + 0.005, -0.026),
                            (x * (radius + 0.035), high + 0.005, 0.026), (x * radius * 0.99, high, 0.03)], 3), 0.0055)
                for x in (-1, 1)]
    return without_uvs(body, lid, grip, *ears)


def without_uvs(*parts):
    return joined(*(mesh(m["positions"], m["triangles"], m["normals"]) for m in parts))


def pan(radius=0.13):
    """A frying pan that hangs by its handle's end at the origin, its inside towards +z."""
    body = lathe([(0, 0), (0.8 * radius, 0)], curve([(0.8 * radius, 0), (0.92 * radius, 0.012), (radius, 0.04)], 2),
                 [(radius, 0.04), (radius - 0.003, 0.041)],
                 curve([(radius - 0.003, 0.041), (0.91 * radius, 0.016), (0.79 * radius, 0.004), (0.0, 0.004)], 2))
    handle = pipe(curve([(0, 0.03, 0.98 * radius), (0, 0.05, radius + 0.06), (0, 0.045, radius + 0.19)], 3), 0.008, 8)
    hung = turned(without_uvs(body, handle), 90)  # up becomes front, front becomes down; so the handle points down
    return moved(turned(hung, 180, (0, 0, 1)), (0, -radius - 0.185, 0))


def bottle(radius=0.037, height=0.3):
    return vase([(radius, 0), (radius, 0.25 * height), (radius, 0.55 * height), (0.6 * radius, 0.7 * height),
                 (0.36 * radius, 0.8 * height), (0.36 * radius, height)], 24, 0.004)


def tap(height=0.28, reach=0.2):
    """A swan-necked tap with two handles; its spout reaches out along +z."""
    neck = curve([(0, 0, 0), (0, 0.6 * height, 0), (0, 0.92 * height, 0.25 * reach), (0, height, 0.55 * reach),
                  (0, 0.9 * height, 0.9 * reach), (0, 0.72 * height, reach)], 4)
    parts = [pipe(neck, 0.011, 12), creased([(0, 0.0), (0.026, 0.0), (0.024, 0.02), (0.012, 0.03)], 20)]
    for side in (-1, 1):
        parts += [pipe([(0, 0.04, 0), (side * 0.05, 0.045, 0)], 0.01, 10),
                  pipe([(side * 0.05, 0.03, 0), (side * 0.055, 0.075, 0.015)], 0.009, 10)]
    return without_uvs(*parts)


def wine_glass(height=0.215, radius=0.042):
    """A goblet, one closed surface of glass: foot, stem, bowl and the bowl's inside; and wine, a hair's breadth off the
    glass."""
    outside = curve([(0.036, 0.0015), (0.02, 0.004), (0.006, 0.012), (0.0045, 0.04), (0.005, 0.4 * height),
                     (0.014, 0.45 * height), (radius, 0.62 * height), (1.02 * radius, 0.76 * height),
                     (0.84 * radius, height)], 3)
    inside = curve([(0.84 * radius - 0.0016, height), (1.02 * radius - 0.0017, 0.76 * height),
                    (radius - 0.0019, 0.63 * height), (0.013, 0.468 * height), (0.0, 0.455 * height)], 3)
    wine = [(r - 0.0008, h + 0.0008) for r, h in inside[::-1] if r > 0.001 and h < 0.68 * height]
    glass = lathe([(0, 0), (0.036, 0)], [(0.036, 0), (0.036, 0.0015)], outside, [outside[-1], inside[0]], inside,
                  segments=24)
    return dict(glass=glass, wine=lathe([(0.0, wine[0][1]), wine[0]], wine, [wine[-1], (0.0, wine[-1][1])],
                                        segments=24))


def tumbler(radius=0.036, height=0.1):
    """A plain drinking glass with a thick bottom."""
    return lathe([(0, 0), (0.82 * radius, 0)], [(0.82 * radius, 0), (radius, height)],
                 [(radius, height), (radius - 0.002, height)],
                 [(radius - 0.002, height), (0.82 * radius - 0.002, 0.01)],
                 [(0.82 * radius - 0.002, 0.01), (0, 0.01)], segments=28)


def cutlery():
    """A fork, a knife and a spoon about their middles, their handles towards +z."""
    handle = lambda a: rounded((-a, 0.001, 0.0), (a, 0.0045, 0.105), 0.0015)
    neck = rounded((-0.0028, 0.001, -0.03), (0.0028, 0.0045, 0.002), 0.0015)
    fork = [handle(0.006), neck, prism([(-0.003, -0.03), (0.003, -0.03), (0.012, -0.045), (-0.012, -0.045)],
                                       0.002, 0.0045),
            *(rounded((x - 0.0017, 0.002, -0.1), (x + 0.0017, 0.0045, -0.044), 0.001)
              for x in (-0.0102, -0.0034, 0.0034, 0.0102))]
    blade = prism([(-0.008, 0.01), (0.009, 0.01), (0.011, -0.07), (0.004, -0.11), (-0.008, -0.12)], 0.001, 0.0028)
    ball = sphere(1.0, 2)
    bowl_ = mesh(ball["positions"] * (0.02, 0.004, 0.03) + (0, 0.006, -0.058), ball["triangles"])
    return flat(*fork), flat(handle(0.008), blade), flat(handle(0.006), neck, bowl_)


def candlestick(height=0.26):
    """A turned stick, and a candle in it."""
    line = curve([(0.05, 0), (0.048, 0.012), (0.014, 0.03), (0.01, 0.06), (0.02, 0.08), (0.009, 0.1),
                  (0.011, 0.8 * height),
                  (0.024, 0.9 * height), (0.016, height)], 3)
    candle = creased([(0.011, height), (0.0105, height + 0.19), (0.006, height + 0.196), (0, height + 0.19)], 16)
    return dict(stick=lathe([(0, 0), line[0]], line, [line[-1], (0, height)], segments=24), candle=candle)


def napkin():
    """A folded cloth, a little lifted."""
    def point(s, t):
        return 0.11 * (s - 0.5), 0.005 + 0.006 * np.sin(np.pi * s) + 0.002 * np.sin(9 * t + 4 * s), 0.2 * (t - 0.5)
    return joined(surface(point, 8, 8), box((-0.054, 0, -0.099), (0.054, 0.0045, 0.099)))
