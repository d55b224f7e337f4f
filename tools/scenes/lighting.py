"""Lamps. `furniture.py` defines what a piece is; the part `bulb` shines."""

import numpy as np

from forms import pipe, surface
from shapes import box, creased, curve, disc, flat, joined, lathe, moved, sphere


def shade(outside, thickness=0.004, segments=32):
    """A lamp's opaque shade, open above and below: its cloth outside, its lining within and on the rims. `outside` is
    its smooth profile, upwards."""
    line = np.asarray(outside, float)
    inside = line[::-1] - (thickness, 0)
    return dict(shade=lathe(line, segments=segments), lining=lathe(
        [line[-1], inside[0]], inside, [inside[-1], line[0]], segments=segments))


def shell(outside, thickness, segments=32):
    """A thin round wall, all of one material: `outside` is its smooth profile, upwards."""
    return joined(*shade(outside, thickness, segments).values())


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
