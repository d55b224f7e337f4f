"""Furniture of a plain household. What takes `look` wears its materials: wool, walnut, oak, and a list of books."""

import numpy as np

import shapes
from forms import cushion, swept


def seat(glb, look, name, width, at, turn, cushions):
    """A sofa or an armchair, its back to local -z."""
    base = shapes.joined(shapes.moved(cushion((width, 0.22, 0.82), 0.18), (0, 0.12, 0)),
                         shapes.moved(cushion((width, 0.62, 0.2), 0.25), (0, 0.2, -0.36)),
                         *(shapes.moved(cushion((0.2, 0.44, 0.84), 0.25), (s * (width / 2 - 0.08), 0.14, 0))
                           for s in (-1, 1)))
    glb.add(name, base, look["wool"], at, turn)
    inner = width - 0.34
    seats = max(1, round(inner / 0.75))
    pad = shapes.joined(*(shapes.moved(cushion((inner / seats - 0.01, 0.17, 0.66), 0.3),
                                       ((k - (seats - 1) / 2) * inner / seats, 0.33, 0.06)) for k in range(seats)))
    glb.add(name + " seat", pad, look["wool"], at, turn)
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    pillow = shapes.turned(cushion((0.42, 0.42, 0.15), 0.5), -18)
    for x, material in cushions:
        glb.add("cushion", pillow, look[material], (at[0] + c * x - s * 0.16, at[1] + 0.48, at[2] - s * x - c * 0.16),
                turn + 8)
    legs = shapes.joined(*(shapes.box((x - 0.03, 0, z - 0.03), (x + 0.03, 0.14, z + 0.03))
                           for x in (-width / 2 + 0.12, width / 2 - 0.12) for z in (-0.32, 0.32)))
    glb.add("legs", legs, look["walnut"], at, turn)


def table(width, depth, height, leg=0.05):
    legs = [shapes.box((x - leg / 2, 0, z - leg / 2), (x + leg / 2, height - 0.035, z + leg / 2))
            for x in (-width / 2 + 0.08, width / 2 - 0.08) for z in (-depth / 2 + 0.08, depth / 2 - 0.08)]
    rim = shapes.box((-width / 2 + 0.06, height - 0.1, -depth / 2 + 0.06),
                     (width / 2 - 0.06, height - 0.035, depth / 2 - 0.06))
    return shapes.joined(shapes.box((-width / 2, height - 0.035, -depth / 2), (width / 2, height, depth / 2), 0.8),
                         rim, *legs)


def chair():
    legs = [swept([(x, 0, z), (0.9 * x, h, z * 0.95)], 0.018, 8) for x in (-0.19, 0.19) for z,
            h in ((0.19, 0.44), (-0.19, 0.92))]
    slats = [shapes.moved(cushion((0.36, 0.07, 0.02), 0.3), (0, y, -0.183)) for y in (0.62, 0.73, 0.84)]
    return shapes.joined(shapes.moved(cushion((0.44, 0.04, 0.42), 0.25), (0, 0.43, 0)), *legs, *slats)


def bookcase(glb, look, at, turn, rng):
    width, height, deep = 1.5, 2.1, 0.3
    shelf = lambda y: shapes.box((-width / 2 + 0.03, y, -deep + 0.02), (width / 2 - 0.03, y + 0.03, 0))
    sides = [shapes.box((s * width / 2 - 0.015, 0, -deep), (s * width / 2 + 0.015, height, 0)) for s in (-1, 1)]
    levels = np.linspace(0.06, height - 0.03, 6)
    glb.add("bookcase", shapes.joined(*sides, *map(shelf, levels), shapes.box(
        (-width / 2, 0.0, -deep), (width / 2, height, -deep + 0.02))), look["oak"], at, turn)
    rows = [[] for _ in look["books"]]
    for y in levels[:-1]:
        x = -width / 2 + 0.04
        while x < width / 2 - 0.1:
            thick, tall, deep_in = rng.uniform(0.015, 0.045), rng.uniform(0.2, 0.32), rng.uniform(0.15, 0.23)
            if rng.random() < 0.9:
                rows[rng.integers(len(rows))].append(
                    shapes.box((x, y + 0.0305, -deep + 0.03), (x + thick, y + 0.03 + tall, -deep + 0.03 + deep_in)))
            x += thick + 0.002
    for row, material in zip(rows, look["books"]):
        glb.add("books", shapes.joined(*row), material, at, turn)
