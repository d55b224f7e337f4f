"""What stands on tables and in kitchens: vessels, plates, cutlery, pots, a tap; about the origin, on y = 0."""

import numpy as np

from forms import pipe, surface
from shapes import box, creased, curve, flat, joined, lathe, mesh, moved, prism, rounded, sphere, turned


def vase(profile, segments=32, thick=0.006):
    """A vessel, open above, whose outside goes through `profile` from its foot to its lip."""
    line = curve(profile, 3)
    inside = [(max(r - thick, 0.001), max(h, line[0, 1] + thick)) for r, h in line[::-1]]
    floor = (0.0, inside[-1][1])
    return lathe([(0.0, line[0, 1]), line[0]], line, [line[-1], inside[0]], [*inside, floor], segments=segments)


def without_uvs(*parts):
    return joined(*(mesh(m["positions"], m["triangles"], m["normals"]) for m in parts))


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


def bottle(radius=0.037, height=0.3):
    return vase([(radius, 0), (radius, 0.25 * height), (radius, 0.55 * height), (0.6 * radius, 0.7 * height),
                 (0.36 * radius, 0.8 * height), (0.36 * radius, height)], 24, 0.004)


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


def pan(radius=0.13):
    """A frying pan that hangs by its handle's end at the origin, its inside towards +z."""
    body = lathe([(0, 0), (0.8 * radius, 0)], curve([(0.8 * radius, 0), (0.92 * radius, 0.012), (radius, 0.04)], 2),
                 [(radius, 0.04), (radius - 0.003, 0.041)],
                 curve([(radius - 0.003, 0.041), (0.91 * radius, 0.016), (0.79 * radius, 0.004), (0.0, 0.004)], 2))
    handle = pipe(curve([(0, 0.03, 0.98 * radius), (0, 0.05, radius + 0.06), (0, 0.045, radius + 0.19)], 3), 0.008, 8)
    hung = turned(without_uvs(body, handle), 90)  # up becomes front, front becomes down; so the handle points down
    return moved(turned(hung, 180, (0, 0, 1)), (0, -radius - 0.185, 0))


def tap(height=0.28, reach=0.2):
    """A swan-necked tap with two handles; its spout reaches out along +z."""
    neck = curve([(0, 0, 0), (0, 0.6 * height, 0), (0, 0.92 * height, 0.25 * reach), (0, height, 0.55 * reach),
                  (0, 0.9 * height, 0.9 * reach), (0, 0.72 * height, reach)], 4)
    parts = [pipe(neck, 0.011, 12), creased([(0, 0.0), (0.026, 0.0), (0.024, 0.02), (0.012, 0.03)], 20)]
    for side in (-1, 1):
        parts += [pipe([(0, 0.04, 0), (side * 0.05, 0.045, 0)], 0.01, 10),
                  pipe([(side * 0.05, 0.03, 0), (side * 0.055, 0.075, 0.015)], 0.009, 10)]
    return without_uvs(*parts)
