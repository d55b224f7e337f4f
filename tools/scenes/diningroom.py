#!/usr/bin/env python3
"""Makes scenes/diningroom.glb: a table laid for six with glasses and silver, in the light of shaded lamps.

Every lamp's shade is opaque, so light leaves it only above and below: pools on the table and the ceiling, and all the
rest is what they give back. Goblets, tumblers and a carafe are smooth glass (ior 1.5) between the lamps and the cloth,
the silver is glossy.

    python3 tools/scenes/diningroom.py [OUT.glb]
"""

import numpy as np

import architecture as arch
import forms
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

LEFT, RIGHT, BACK, FRONT, HIGH = -2.7, 2.7, 0.0, 5.0, 2.7
TABLE = (0.0, 0.76, 2.35)  # the middle of the table's top
LONG, WIDE = 2.3, 1.08


def materials(glb):
    boards = pictures.boards(320, 8, (0.6, 0.41, 0.25), (0.42, 0.27, 0.15), 14)
    rug = pictures.carpet(320, 224, (0.2, 0.27, 0.42), (0.62, 0.22, 0.17), (0.86, 0.78, 0.6), 6)
    grain = pictures.few(pictures.wood(256, 128, [0.6, 0.39, 0.23], [0.42, 0.25, 0.13], 15))
    runner = pictures.runner(256, 64, (0.86, 0.83, 0.75), (0.62, 0.2, 0.16))
    paper = pictures.wallpaper(96, [0.7, 0.76, 0.72], [0.62, 0.69, 0.65])
    m = {name: printed(glb, name, image) for name, image in dict(
        floor=boards, rug=rug, grain=grain, paper=paper).items()}
    m["runner"] = printed(glb, "runner", runner, doubleSided=True)
    for name, color in dict(
            ceiling=(0.86, 0.85, 0.82), white=(0.84, 0.83, 0.8), wood=(0.34, 0.19, 0.1), seat=(0.25, 0.36, 0.33),
            shade=(0.2, 0.32, 0.3), linen=(0.86, 0.85, 0.82), blue=(0.16, 0.26, 0.46), clay=(0.66, 0.32, 0.19),
            green=(0.22, 0.4, 0.28), red=(0.6, 0.12, 0.09), black=(0.05, 0.05, 0.05), earth=(0.1, 0.07, 0.05),
            wax=(0.9, 0.87, 0.78), yellow=(0.85, 0.66, 0.12),
            pages=(0.84, 0.79, 0.68)).items():
        m[name] = matte(glb, name, color)
    for name, color in dict(leaves=(0.17, 0.37, 0.13), curtain=(0.48, 0.16, 0.15)).items():
        m[name] = matte(glb, name, color, doubleSided=True)
    m["china"] = glb.material("china", (0.87, 0.86, 0.83), roughness=0.2)
    m["wine"] = glb.material("wine", (0.22, 0.012, 0.03), roughness=0.08)
    m["silver"] = glb.material("silver", (0.92, 0.9, 0.86), metallic=1.0, roughness=0.18)
    m["brass"] = glb.material("brass", (0.88, 0.7, 0.38), metallic=1.0, roughness=0.3)
    m["glass"] = glb.material("glass", roughness=0.0, extensions=dict(
        KHR_materials_transmission=dict(transmissionFactor=1.0), KHR_materials_ior=dict(ior=1.5),
        KHR_materials_volume=dict(thicknessFactor=0.004)))
    return m


def house(glb, m):
    walls = arch.room(LEFT, RIGHT, BACK, FRONT, HIGH, 0.15)
    place(glb, "wall", walls, dict.fromkeys(walls, m["paper"]))
    glb.add("floor", shapes.box((LEFT - 0.1, -0.1, BACK - 0.1), (RIGHT + 0.1, 0, FRONT + 0.1), 1.8), m["floor"])
    glb.add("ceiling", shapes.box((LEFT - 0.1, HIGH, BACK - 0.1), (RIGHT + 0.1, HIGH + 0.1, FRONT + 0.1)), m["ceiling"])
    door = 3.2  # where the door in the right wall begins
    for name, length, at, turn, gaps in (
            ("back", RIGHT - LEFT, (LEFT, 0, BACK), 0, ()), ("left", FRONT, (LEFT, 0, FRONT), 90, ()),
            ("right", FRONT, (RIGHT, 0, BACK), -90, [(door - 0.09, door + 0.99)]),
            ("front", RIGHT - LEFT, (RIGHT, 0, FRONT), 180, ())):
        glb.add(f"{name} panelling", arch.wainscot(length, 0.9, gaps), m["white"], at, turn)
        cornice = shapes.bars((0, length, HIGH - 0.06, HIGH, -0.005, 0.1),
                              (0, length, HIGH - 0.12, HIGH - 0.06, -0.005, 0.05))
        glb.add(f"{name} cornice", cornice, m["white"], at, turn)
    place(glb, "door frame", arch.door_frame(0.9, 2.06, 0.05), dict(frame=m["white"]), (RIGHT - 0.001, 0, door),
          -90)
    place(glb, "door", arch.door_leaf(), dict(door=m["white"], metal=m["brass"]), (RIGHT, 0.01, door + 0.02), -90)
    for i, (z, width) in enumerate(((1.35, 0.95), (2.35, 0.95))):  # drawn for the night, the window is behind them
        cloth = household.curtain(width + 0.16, 2.36, 8, 0.05, seed=i + 5)
        place(glb, f"curtain {i + 1}", cloth, dict(cloth=m["curtain"]), (LEFT + 0.13, 0.02, z), 90)
    rod = forms.pipe([(LEFT + 0.13, 2.41, 0.7), (LEFT + 0.13, 2.41, 3.0)], 0.015, 10)
    ends = [shapes.moved(shapes.sphere(0.028, 2), (LEFT + 0.13, 2.41, z)) for z in (0.69, 3.01)]
    holders = [shapes.box((LEFT - 0.01, 2.4, z), (LEFT + 0.14, 2.42, z + 0.02)) for z in (0.78, 2.9)]
    glb.add("curtain rod", shapes.flat(rod, *ends, *holders), m["brass"])


def lamps(glb, m):
    """Two drums over the table, two lamps on the sideboard, two on the wall, one standing in the corner."""
    warm = (1.0, 0.8, 0.56)
    wear = dict(metal=m["brass"], shade=m["shade"], lining=m["linen"], foot=m["brass"])
    hanging, bulb = lighting.pendant(0.98, 0.22, 0.24), glowing(glb, "pendant bulb", 150, color=warm)
    for i, x in enumerate((-0.5, 0.55)):
        place(glb, f"pendant {i + 1}", hanging, dict(wear, bulb=bulb), (x, HIGH, TABLE[2]), 40 * i)
    bulb = glowing(glb, "bulb", 450, color=warm)
    lamp = lighting.table_lamp(0.5, 0.16, 0.03)
    for i, (x, foot) in enumerate(((-1.02, "blue"), (0.98, "blue"))):
        place(glb, f"table lamp {i + 1}", lamp, dict(wear, bulb=bulb, foot=m[foot]), (x, 0.925, 0.24))
    bracket = lighting.sconce()
    for i, z in enumerate((0.75, 2.3)):
        place(glb, f"sconce {i + 1}", bracket, dict(wear, shade=m["white"], bulb=bulb), (RIGHT, 1.72, z), -90)
    at = (LEFT + 0.42, 0, 0.42)
    pole = shapes.creased([(0, 0), (0.15, 0), (0.15, 0.02), (0.016, 0.035), (0.012, 1.45), (0, 1.45)], 24)
    glb.add("standing lamp", pole, m["brass"], at)
    place(glb, "standing lamp", lighting.shade([(0.24, 1.4), (0.15, 1.68)], 0.005, 36), wear, at)
    arms = [forms.pipe([(0, 1.448, 0), (0.22 * np.cos(a), 1.44, 0.22 * np.sin(a))], 0.004, 5) for a in (0, 2.1, 4.2)]
    glb.add("shade's arms", shapes.flat(*arms), m["brass"], at)
    glb.add("standing bulb", shapes.moved(shapes.sphere(0.045, 1), (0, 1.49, 0)), bulb, at)


def laid(glb, m, rng, parts, name, x, z, turn):
    """One place at the table, as seen from its chair; everything a little off."""
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    for what, wear, dx, dz, lift, askew in (
            ("plate", "china", 0, 0, 0, 0), ("bowl", "china", 0, 0, 0.006, 0), ("fork", "silver", -0.185, 0.02, 0, 3),
            ("knife", "silver", 0.175, 0.02, 0, 3), ("spoon", "silver", 0.215, 0.02, 0, 3),
            ("napkin", "linen" if rng.random() < 0.6 else "red", -0.26, 0.02, 0, 6),
            ("goblet", None, 0.17, -0.2, 0, 0), ("tumbler", "glass", 0.265, -0.15, 0, 0)):
        dx, dz = (dx, dz) + rng.normal(0, 0.006, 2)
        at = (x + c * dx + s * dz, TABLE[1] + lift, z - s * dx + c * dz)
        angle = turn + rng.normal(0, 1) * askew
        if what == "goblet":
            place(glb, f"{what} {name}", parts[what], dict(glass=m["glass"], wine=m["wine"]), at, angle)
        else:
            glb.add(f"{what} {name}", parts[what], m[wear], at, angle)


def table(glb, m):
    rng = np.random.default_rng(6)
    x, top, z = TABLE
    place(glb, "table", furniture.table(LONG, WIDE, top), dict(wood=m["wood"], top=m["grain"]), (x, 0, z))
    over = 0.2
    cloth = forms.surface(lambda s, t: (
        np.clip((2 * s - 1) * (LONG / 2 + over), -LONG / 2 - 0.004, LONG / 2 + 0.004),
        0.003 - np.maximum(np.abs(2 * s - 1) * (LONG / 2 + over) - LONG / 2, 0) + 0 * t, 0.34 * (t - 0.5)), 60, 4)
    glb.add("table runner", cloth, m["runner"], (x, top, z))
    parts = dict(plate=tableware.plate(), bowl=tableware.bowl(0.085, 0.045), napkin=tableware.napkin(),
                 goblet=tableware.wine_glass(), tumbler=tableware.tumbler(),
                 **dict(zip(("fork", "knife", "spoon"), tableware.cutlery())))
    chair = furniture.chair()
    spots = [(dx, side) for side in (1, -1) for dx in (-0.7, 0.02, 0.72)]
    for i, (dx, side) in enumerate(spots):
        turn = 0 if side > 0 else 180
        laid(glb, m, rng, parts, i + 1, x + dx, z + side * (WIDE / 2 - 0.185), turn)
        pulled = (0.02, 0.05, 0.02, 0.0, 0.06, 0.03)[i]
        place(glb, f"chair {i + 1}", chair, dict(wood=m["wood"], seat=m["seat"]),
              (x + dx + rng.normal(0, 0.03), 0, z + side * (WIDE / 2 + 0.16 + pulled)), 180 + turn + rng.normal(0, 5))
    top += 0.003
    stick = tableware.candlestick()
    for i, dx in enumerate((-0.26, 0.42)):
        place(glb, f"candle {i + 1}", stick, dict(stick=m["silver"], candle=m["wax"]), (x + dx, top, z + 0.02))
    flowers = nature.plant(rng, 40, 0.17, (0.055, 0.13))
    place(glb, "posy", flowers, dict(pot=m["blue"], earth=m["earth"], leaves=m["leaves"]), (x + 0.04, top, z - 0.02))
    for i in range(9):
        a, r = i * 2.4, 0.05 + 0.012 * i
        glb.add(f"blossom {i + 1}", shapes.sphere(0.02, 1), m["yellow" if i % 3 else "red"],
                (x + 0.04 + r * np.cos(a), top + 0.29 - 0.014 * i, z - 0.02 + r * np.sin(a)))
    carafe = lathe_glass([(0.05, 0.001), (0.07, 0.03), (0.066, 0.1), (0.03, 0.17), (0.028, 0.21), (0.037, 0.25)])
    glb.add("carafe", carafe, m["glass"], (x - 0.62, top, z + 0.02))
    glb.add("salad bowl", tableware.bowl(0.15, 0.095), m["china"], (x + 0.74, top, z))
    for i in range(10):
        a = i * 2.4
        leaf = shapes.sphere(0.036, 1)
        leaf = shapes.turned(shapes.mesh(leaf["positions"] * (1.3, 0.45, 1), leaf["triangles"]), 35,
                             (np.cos(a), 0.3, np.sin(a)))
        glb.add(f"lettuce {i + 1}", leaf, m["green" if i % 4 else "red"],
                (x + 0.74 + 0.022 * i**0.6 * np.cos(a), top + 0.075 - 0.0015 * i, z + 0.022 * i**0.6 * np.sin(a)))


def lathe_glass(profile, thick=0.003):
    """A vessel of glass as one closed surface."""
    line = shapes.curve(profile)
    inside = [(max(r - thick, 0.002), max(h, 0.008)) for r, h in line[::-1] if h > 0.006]
    inside.append((0.0, 0.008))
    return shapes.lathe([(0, 0), line[0]], line, [line[-1], inside[0]], inside, segments=32)


def furnishings(glb, m):
    rng = np.random.default_rng(17)
    glb.add("rug", household.rug(3.5, 2.44, 0.012), m["rug"], (0.04, 0, 2.38), 1.5)
    board = furniture.cabinet(2.4, 0.9, 0.48, 4, (1, 2.4))
    place(glb, "sideboard", board, dict(body=m["wood"], fronts=m["wood"], top=m["grain"], metal=m["brass"]),
          (0, 0, 0.045))
    glb.add("fruit bowl", tableware.bowl(0.17, 0.09), m["china"], (0.3, 0.925, 0.27))
    for i, (dx, dy, dz, color) in enumerate(((-0.06, 0.05, 0.02, "red"), (0.06, 0.05, 0.04, "yellow"),
                                             (0.03, 0.05, -0.06, "green"), (0.0, 0.11, 0.01, "red"))):
        glb.add(f"fruit {i + 1}", shapes.sphere(0.04, 2), m[color], (0.3 + dx, 0.925 + dy, 0.27 + dz))
    glb.add("teapot", tableware.teapot(1.15), m["china"], (-0.42, 0.925, 0.26), 30)
    decanter = lathe_glass([(0.055, 0.001), (0.06, 0.05), (0.055, 0.12), (0.02, 0.17), (0.018, 0.22), (0.026, 0.24)])
    glb.add("decanter", decanter, m["glass"], (-0.1, 0.925, 0.22))
    covers = household.covers(m, "red", "blue", "green", "clay", "black")
    place(glb, "book pile", household.book_pile(3, rng, 5), covers, (0.66, 0.925, 0.3), 20)

    # A dresser: plates on edge, mugs, books.
    shelf, levels = furniture.shelf(1.1, 2.0, 0.34, 5)
    place(glb, "dresser", shelf, dict(wood=m["wood"]), (RIGHT - 0.045, 0, 1.52), -90)
    plate, mug = tableware.plate(0.12), tableware.mug()
    stood = shapes.turned(plate, 74)
    out = RIGHT - 0.045
    for i in range(4):
        glb.add(f"plate on edge {i + 1}", stood, m["china"],
                (out - 0.12, levels[4] + 0.12, 1.13 + 0.26 * i), -90)
    for i in range(3):
        glb.add(f"mug {i + 1}", mug, m["clay" if i % 2 else "china"], (out - 0.18, levels[2], 1.3 + 0.21 * i),
                70 + 50 * i)
    for i in (0, 1):
        row = household.books(1.05, 0.3, 0.28, rng, 5, 0.8)
        place(glb, f"books {i + 1}", row, covers, (out - 0.01, levels[i], 1.0), -90)
    place(glb, "plant", nature.plant(rng, 40, 0.55, (0.18, 0.36)), dict(
        pot=m["clay"], earth=m["earth"], leaves=m["leaves"]), (2.25, 0, 0.5))


def hang(glb, m):
    colours = ((0.75, 0.2, 0.12), (0.15, 0.3, 0.5), (0.9, 0.65, 0.2))
    evening = ((0.45, 0.5, 0.68), (0.97, 0.76, 0.5)), (0.2, 0.22, 0.14)
    prints = (("valley", pictures.landscape(224, 144, 21, *evening), 1.25, 0.82, "brass", (0.0, 1.82, BACK), 0),
              ("fern", pictures.botanical(96, 128, 14), 0.4, 0.52, "black", (-1.6, 1.7, BACK), 0),
              ("twig", pictures.botanical(96, 128, 15), 0.4, 0.52, "black", (1.58, 1.7, BACK), 0),
              ("shapes", pictures.abstract(96, 128, 12, colours), 0.5, 0.66, "black", (LEFT, 1.65, 3.7), 90))
    for name, image, width, height, frame, at, turn in prints:
        wear = dict(frame=m[frame], mat=m["white"], print=printed(glb, name, image))
        place(glb, name, household.picture(width, height, 0.035, 0.05), wear, at, turn)


def main():
    glb = scene.begin("diningroom", (640, 360))
    m = materials(glb)
    for part in (house, lamps, table, furnishings, hang):
        part(glb, m)
    glb.camera("room", (1.3, 1.4, 4.0), (-0.17, 0.95, 1.6), 46)
    scene.save(glb)


if __name__ == "__main__":
    main()
