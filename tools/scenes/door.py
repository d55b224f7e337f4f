#!/usr/bin/env python3
"""Makes scenes/door.glb: an old dining room at night, lit only through a door ajar.

The room behind the door has the lamps, and they shine at its ceiling. Light gets here after at least two bounces
through a gap of two hand's breadths, so a path from the camera must find the gap and then a lamp's bowl; paths from
the lamps meet it halfway. All surfaces are Lambertian.

    python3 tools/scenes/door.py [OUT.glb]
"""

import numpy as np

import architecture as arch
import furniture
import household
import lighting
import nature
import pictures
import scene
import shapes
import tableware
from glb import place
from looks import glowing, matte, printed

WIDE, HIGH, DEEP, THICK = 5.2, 2.75, 4.7, 0.13  # this room; it reaches from x = -WIDE / 2 and from z = 0 to DEEP
HINGE, OPENING, AJAR = 0.35, 0.9, 27  # the door: the opening's left edge, its width, and degrees


def materials(glb):
    floor = glb.texture("boards", pictures.boards(320, 8, (0.68, 0.49, 0.32), (0.5, 0.33, 0.2), 3))
    grain = glb.texture("grain", pictures.few(pictures.wood(256, 128, [0.66, 0.45, 0.28], [0.47, 0.29, 0.16], 5)))
    rug = pictures.carpet(320, 224, (0.68, 0.22, 0.17), (0.22, 0.29, 0.45), (0.88, 0.76, 0.52))
    m = dict(floor=matte(glb, "floor", textures=floor), grain=matte(glb, "table top", textures=grain),
             rug=printed(glb, "rug", rug))
    for name, color in dict(
            wall=(0.66, 0.69, 0.58), ceiling=(0.84, 0.82, 0.78), white=(0.85, 0.84, 0.8), wood=(0.34, 0.19, 0.1),
            oak=(0.46, 0.29, 0.15), brass=(0.62, 0.47, 0.2), cloth=(0.2, 0.28, 0.32), pad=(0.7, 0.6, 0.42),
            seat=(0.45, 0.12, 0.1), china=(0.88, 0.87, 0.83), blue=(0.12, 0.22, 0.45), clay=(0.66, 0.3, 0.16),
            green=(0.2, 0.42, 0.27), earth=(0.1, 0.07, 0.05), pages=(0.84, 0.78, 0.65),
            bright=(0.88, 0.85, 0.78), black=(0.05, 0.05, 0.05), yellow=(0.8, 0.6, 0.14),
            apple=(0.6, 0.1, 0.06)).items():
        m[name] = matte(glb, name, color)
    m["both"] = matte(glb, "leaves", (0.16, 0.36, 0.12), doubleSided=True)
    m["shade"] = matte(glb, "lamp shade", (0.75, 0.62, 0.42))
    return m


def house(glb, m):
    """This room and the bright one behind it, and the door."""
    left, far = -WIDE / 2, -3.8
    opening = (HINGE, HINGE + OPENING, 0, 2.06)
    here = arch.room(left, -left, 0, DEEP, HIGH, THICK, back=[opening])
    place(glb, "room", here, dict.fromkeys(here, m["wall"]))
    # Its walls end inside the one between the rooms, as they are thinner.
    there = arch.room(left + 1.4, -left, far, -THICK, HIGH, 0.1, front=None)
    place(glb, "bright room", there, dict.fromkeys(there, m["bright"]))
    glb.add("floor", shapes.box((left - 0.05, -0.1, far - 0.05), (0.05 - left, 0, DEEP + 0.05), 2.0), m["floor"])
    glb.add("ceiling", shapes.box((left - 0.05, HIGH, far - 0.05), (0.05 - left, HIGH + 0.1, DEEP + 0.05)),
            m["ceiling"])
    rail = shapes.flat(*(shapes.box((a, HIGH - 0.11, b), (c, HIGH, d)) for a, b, c, d in (
        (left, 0, -left, 0.05), (left, 0, left + 0.05, DEEP), (-left - 0.05, 0, -left, DEEP))))
    glb.add("cornice", rail, m["ceiling"])
    skirting = arch.skirting(WIDE, 0.13, [(HINGE - left - 0.09, HINGE + OPENING - left + 0.09)])
    glb.add("skirting", skirting, m["white"], (left, 0, 0))
    glb.add("skirting left", arch.skirting(DEEP, 0.13), m["white"], (left, 0, DEEP), 90)
    glb.add("skirting right", arch.skirting(DEEP, 0.13), m["white"], (-left, 0, 0), -90)
    place(glb, "door frame", arch.door_frame(OPENING, 2.06, THICK), dict(frame=m["white"]), (HINGE, 0, 0))
    leaf = arch.door_leaf(OPENING - 0.05, 2.02)
    place(glb, "door", leaf, dict(door=m["white"], metal=m["brass"]), (HINGE + 0.025, 0.012, -0.005), -AJAR)


def lamps(glb, m):
    """Standing lamps with their light upwards, none to be seen from here; and two here that are off."""
    bulb = glowing(glb, "bulb", 26000.0, color=(1.0, 0.86, 0.68))
    lamp = lighting.uplighter(1.7)
    for i, (x, z) in enumerate(((-0.8, -3.3), (2.2, -3.35), (2.3, -0.6))):
        place(glb, f"uplighter {i + 1}", lamp, dict(foot=m["brass"], bowl=m["brass"], bulb=bulb), (x, 0, z))
    off = lighting.table_lamp(0.52, 0.17)
    off.pop("bulb")
    place(glb, "table lamp", off, dict(foot=m["blue"], shade=m["shade"], lining=m["china"]), (2.36, 0.875, 0.75))
    hanging = lighting.pendant(0.82, 0.22, 0.22)
    place(glb, "pendant", hanging, dict(metal=m["brass"], shade=m["shade"], lining=m["china"], bulb=m["china"]),
          (0.1, HIGH, 2.1))


def table(glb, m):
    """The table with three teapots, and what else was left on it."""
    x, z, turn = 0.0, 2.1, 0
    place(glb, "table", furniture.table(1.9, 1.0), dict(wood=m["wood"], top=m["grain"]), (x, 0, z), turn)
    chair = furniture.chair()
    for i, (dx, dz, angle) in enumerate(((-0.45, -0.62, 3), (0.5, -0.72, -12), (1.3, 0.1, -84), (-1.32, -0.1, 70),
                                         (0.42, 0.74, 195))):
        place(glb, f"chair {i + 1}", chair, dict(wood=m["wood"], seat=m["seat"]), (x + dx, 0, z + dz), angle)
    pot = tableware.teapot()
    for i, (dx, dz, angle, color, scale) in enumerate(((-0.42, 0.18, 25, "china", 1.25),
                                                       (0.1, -0.02, 155, "yellow", 1.1),
                                                       (0.52, 0.17, -35, "blue", 1.25))):
        glb.add(f"teapot {i + 1}", pot, m[color], (x + dx, 0.75, z + dz), angle, scale)
    mug = tableware.mug()
    for i, (dx, dz, angle) in enumerate(((-0.15, 0.3, 40), (0.28, 0.3, 200), (-0.68, -0.1, 120))):
        glb.add(f"mug {i + 1}", mug, m["china"], (x + dx, 0.75, z + dz), angle)
    glb.add("fruit bowl", tableware.bowl(0.16, 0.09), m["green"], (x - 0.2, 0.75, z - 0.22))
    for i, (dx, dy, dz, color) in enumerate(((-0.06, 0.05, 0.02, "apple"), (0.05, 0.05, 0.05, "yellow"),
                                             (0.03, 0.05, -0.06, "apple"), (0.0, 0.105, 0.01, "apple"))):
        fruit = shapes.sphere(0.04, 2)
        glb.add(f"fruit {i + 1}", fruit, m[color], (x - 0.2 + dx, 0.75 + dy, z - 0.22 + dz))
    glb.add("vase", tableware.vase([(0.05, 0), (0.085, 0.06), (0.09, 0.13), (0.04, 0.22), (0.05, 0.29)]), m["green"],
            (x + 0.68, 0.75, z - 0.22))


def furnishings(glb, m):
    rng = np.random.default_rng(4)
    glb.add("rug", household.rug(3.2, 2.24, 0.011), m["rug"], (0.05, 0, 2.15), 2)
    right = WIDE / 2
    board = furniture.cabinet(1.7, 0.85, 0.45, 3, (1, 2.6))
    place(glb, "sideboard", board, dict(body=m["oak"], fronts=m["oak"], top=m["grain"], metal=m["brass"]),
          (right, 0, 1.35), -90)
    for i, (z, profile, color) in enumerate((
            (1.2, [(0.06, 0), (0.1, 0.09), (0.075, 0.2), (0.045, 0.27), (0.07, 0.33)], "china"),
            (1.5, [(0.05, 0), (0.06, 0.05), (0.11, 0.12), (0.1, 0.17), (0.06, 0.2)], "clay"),
            (1.95, [(0.04, 0), (0.05, 0.1), (0.03, 0.24), (0.022, 0.34), (0.034, 0.37)], "blue"))):
        glb.add(f"jar {i + 1}", tableware.vase(profile), m[color], (right - 0.24, 0.875, z))
    covers = household.covers(m, "seat", "blue", "green", "oak", "black")
    shelf, levels = furniture.shelf(1.0, 2.0, 0.3, 5)
    place(glb, "bookcase", shelf, dict(wood=m["oak"]), (-1.75, 0, 0.02))
    for i, level in enumerate(levels):
        row = household.books(0.95, 0.34, 0.27, rng, 5, rng.uniform(0.5, 0.95))
        place(glb, f"books {i + 1}", row, covers, (-2.22, level, 0.03))
    place(glb, "book pile", household.book_pile(4, rng, 5), covers, (2.33, 0.875, 2.1), 80)
    place(glb, "armchair", furniture.armchair(), dict(cloth=m["cloth"], pad=m["pad"], wood=m["wood"]),
          (-0.72, 0, 0.62), 18)
    place(glb, "plant", nature.plant(rng, 34, 0.5, (0.17, 0.34)), dict(
        pot=m["clay"], earth=m["earth"], leaves=m["both"]), (2.2, 0, 0.32))
    clock = shapes.turned(shapes.creased([(0, 0.0), (0.17, 0), (0.17, 0.04), (0.15, 0.04), (0.15, 0.03), (0, 0.03)],
                                         32), 90)
    glb.add("clock", clock, m["china"], (-0.93, 1.98, 0.0))
    hands = shapes.bars((-0.006, 0.006, -0.02, 0.12, 0.032, 0.035), (-0.02, 0.08, -0.007, 0.007, 0.036, 0.039))
    glb.add("hands", hands, m["black"], (-0.93, 1.98, 0.0))


def hang(glb, m):
    """Pictures: two on the wall with the door, three over the sideboard."""
    prints = (
        ("abstract", pictures.abstract(96, 128, 5, ((0.75, 0.2, 0.12), (0.15, 0.3, 0.5), (0.9, 0.65, 0.2),
                                                    (0.1, 0.1, 0.1)))),
        ("hills", pictures.landscape(192, 128, 2)), ("fern", pictures.botanical(96, 128, 1)),
        ("twig", pictures.botanical(96, 128, 6)), ("evening", pictures.landscape(
            160, 120, 9, ((0.3, 0.3, 0.5), (0.95, 0.6, 0.35)), (0.12, 0.14, 0.2))))
    right = WIDE / 2
    spots = ((0.5, 0.66, "black", (1.72, 1.62, 0), 0), (0.84, 0.58, "brass", (-0.3, 1.62, 0), 0),
             (0.4, 0.52, "wood", (right, 1.75, 0.85), -90), (0.4, 0.52, "wood", (right, 1.74, 1.36), -90),
             (0.64, 0.5, "brass", (right, 1.76, 2.02), -90))
    for (name, image), (width, height, frame, at, turn) in zip(prints, spots):
        piece = household.picture(width, height, 0.03, 0.05)
        place(glb, name, piece, dict(
            frame=m[frame], mat=m["china"], print=printed(glb, name, image)), at, turn)


def main():
    glb = scene.begin("door", (640, 360))
    m = materials(glb)
    for part in (house, lamps, table, furnishings, hang):
        part(glb, m)
    glb.camera("table", (-1.75, 1.48, 4.45), (0.6, 0.96, 0.9), 41)
    scene.save(glb)


if __name__ == "__main__":
    main()
