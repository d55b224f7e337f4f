"""Chairs and tables, cupboards and shelves. A piece is a dict of meshes by what they are made of, for `glb.place`; it
stands on y = 0 about x = 0, its back at or about z = 0 where it has one, and faces +z. Lengths in metres."""

import numpy as np

from forms import cushion, pipe, swept
from shapes import bars, box, curve, flat, joined, lathe, moved, prism, rounded, turned


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


def sofa(glb, look, name, width, at, turn, cushions):
    """A sofa, or an armchair if narrow, its back to local -z: softer than `armchair`, with `cushions` (x, name). It
    adds itself and wears `look`'s wool and walnut."""
    base = joined(moved(cushion((width, 0.22, 0.82), 0.18), (0, 0.12, 0)),
                  moved(cushion((width, 0.62, 0.2), 0.25), (0, 0.2, -0.36)),
                  *(moved(cushion((0.2, 0.44, 0.84), 0.25), (s * (width / 2 - 0.08), 0.14, 0))
                    for s in (-1, 1)))
    glb.add(name, base, look["wool"], at, turn)
    inner = width - 0.34
    seats = max(1, round(inner / 0.75))
    pad = joined(*(moved(cushion((inner / seats - 0.01, 0.17, 0.66), 0.3),
                         ((k - (seats - 1) / 2) * inner / seats, 0.33, 0.06)) for k in range(seats)))
    glb.add(name + " seat", pad, look["wool"], at, turn)
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    pillow = turned(cushion((0.42, 0.42, 0.15), 0.5), -18)
    for x, material in cushions:
        glb.add("cushion", pillow, look[material], (at[0] + c * x - s * 0.16, at[1] + 0.48, at[2] - s * x - c * 0.16),
                turn + 8)
    legs = joined(*(box((x - 0.03, 0, z - 0.03), (x + 0.03, 0.14, z + 0.03))
                    for x in (-width / 2 + 0.12, width / 2 - 0.12) for z in (-0.32, 0.32)))
    glb.add("legs", legs, look["walnut"], at, turn)


def plain_chair():
    """All of wood with three slats, one mesh with texture coordinates; `chair` has rungs and a padded seat."""
    legs = [swept([(x, 0, z), (0.9 * x, h, z * 0.95)], 0.018, 8)
            for x in (-0.19, 0.19) for z, h in ((0.19, 0.44), (-0.19, 0.92))]
    slats = [moved(cushion((0.36, 0.07, 0.02), 0.3), (0, y, -0.183)) for y in (0.62, 0.73, 0.84)]
    return joined(moved(cushion((0.44, 0.04, 0.42), 0.25), (0, 0.43, 0)), *legs, *slats)


def plain_table(width, depth, height, leg=0.05):
    """Straight legs, one mesh with texture coordinates; `table` has tapered ones and a top of its own."""
    legs = [box((x - leg / 2, 0, z - leg / 2), (x + leg / 2, height - 0.035, z + leg / 2))
            for x in (-width / 2 + 0.08, width / 2 - 0.08) for z in (-depth / 2 + 0.08, depth / 2 - 0.08)]
    top = box((-width / 2, height - 0.035, -depth / 2), (width / 2, height, depth / 2), 0.8)
    rim = box((-width / 2 + 0.06, height - 0.1, -depth / 2 + 0.06),
              (width / 2 - 0.06, height - 0.035, depth / 2 - 0.06))
    return joined(top, rim, *legs)


def full_bookcase(glb, look, at, turn, rng):
    """With plain boxes for books; `shelf` is empty, for `household.books`. It adds itself and wears `look`'s oak and
    books."""
    width, height, deep = 1.5, 2.1, 0.3
    shelf = lambda y: box((-width / 2 + 0.03, y, -deep + 0.02), (width / 2 - 0.03, y + 0.03, 0))
    sides = [box((s * width / 2 - 0.015, 0, -deep), (s * width / 2 + 0.015, height, 0)) for s in (-1, 1)]
    levels = np.linspace(0.06, height - 0.03, 6)
    glb.add("bookcase", joined(*sides, *map(shelf, levels), box(
        (-width / 2, 0.0, -deep), (width / 2, height, -deep + 0.02))), look["oak"], at, turn)
    rows = [[] for _ in look["books"]]
    for y in levels[:-1]:
        x = -width / 2 + 0.04
        while x < width / 2 - 0.1:
            thick, tall, deep_in = rng.uniform(0.015, 0.045), rng.uniform(0.2, 0.32), rng.uniform(0.15, 0.23)
            if rng.random() < 0.9:
                rows[rng.integers(len(rows))].append(
                    box((x, y + 0.0305, -deep + 0.03), (x + thick, y + 0.03 + tall, -deep + 0.03 + deep_in)))
            x += thick + 0.002
    for row, material in zip(rows, look["books"]):
        glb.add("books", joined(*row), material, at, turn)
