#!/usr/bin/env python3
"""Makes scenes/house.glb: a house in its garden, seen from the back of the living room. Sun and sky come in below the
veranda's roof through an open door and two windows, one of them a room away: most of what is seen is lit by what the
sun's patches and the garden send in, by way of few openings. Wholly Lambert; the camera `garden` looks from outside.

    python3 tools/scenes/house.py [OUT.glb]
"""

import numpy as np

import architecture as arch
import nature
import scene
import shapes
from forms import cushion, swept
from furniture import full_bookcase, plain_chair, plain_table, sofa
from household import drape
from looks import lit, matte, printed
from pictures import blocks, cloudy, damask, lawn, planks, sky, wood

WEST, MIDDLE, EAST, DEEP, HIGH, WALL = -7.0, -3.25, 3.3, 2.6, 2.7, 0.24
SKY_RADIUS = 17.0
PORCH = 1.7  # how deep the veranda is
SUN = np.array([-0.36, 0.5, -0.8])  # towards it
DOOR = (-2.75, 0.0, 0.45, 2.35)
WINDOW, DINING_WINDOW = (1.15, 0.6, 2.85, 2.25), (-6.3, 0.7, -4.3, 2.25)  # x0, y0, x1, y1


def looks(glb):
    return dict(
        wall=printed(glb, "limewash", cloudy([0.86, 0.83, 0.77], [0.81, 0.77, 0.7], seed=3)),
        boards=printed(glb, "floor boards", planks([0.56, 0.38, 0.22], [0.42, 0.26, 0.14], 8, seed=5)),
        deck=printed(glb, "deck", planks([0.5, 0.42, 0.34], [0.36, 0.29, 0.22], 8, seed=7)),
        paint=matte(glb, "white paint", (0.8, 0.79, 0.76)), ceiling=matte(glb, "ceiling", (0.84, 0.83, 0.8)),
        siding=printed(glb, "siding", planks([0.66, 0.72, 0.72], [0.56, 0.63, 0.64], 8, seed=2)),
        roof=printed(glb, "roof tiles", blocks([0.45, 0.2, 0.13], [0.34, 0.14, 0.1], [0.18, 0.08, 0.06], 8, 8, seed=3)),
        oak=printed(glb, "oak", wood(128, 128, [0.5, 0.33, 0.19], [0.36, 0.22, 0.11], 8)),
        walnut=matte(glb, "walnut", (0.22, 0.13, 0.075)), iron=matte(glb, "iron", (0.05, 0.05, 0.055)),
        wool=printed(glb, "blue wool", cloudy([0.13, 0.24, 0.36], [0.09, 0.17, 0.28], 24, seed=4)),
        ochre=matte(glb, "ochre cushion", (0.72, 0.45, 0.1)), rust=matte(glb, "rust cushion", (0.55, 0.16, 0.08)),
        cream=matte(glb, "cream linen", (0.78, 0.73, 0.63), doubleSided=True),
        clay=matte(glb, "clay", (0.56, 0.25, 0.14)),
        rug=printed(glb, "rug", damask([0.5, 0.1, 0.08], [0.14, 0.13, 0.26], [0.76, 0.62, 0.36])),
        leaf=matte(glb, "leaves", (0.15, 0.3, 0.06), doubleSided=True),
        pale=matte(glb, "pale leaves", (0.28, 0.4, 0.1), doubleSided=True),
        bark=matte(glb, "bark", (0.2, 0.14, 0.1)),
        lawn=printed(glb, "lawn", lawn([0.2, 0.36, 0.09], [0.11, 0.24, 0.05])),
        books=[matte(glb, f"book {i + 1}", c) for i, c in enumerate((
            (0.5, 0.1, 0.08), (0.1, 0.2, 0.35), (0.65, 0.55, 0.35), (0.12, 0.28, 0.16), (0.3, 0.12, 0.25)))])


def window(glb, look, hole, z, panes=2):
    """A frame with a mullion and a bar, and a sill, in a hole of the front wall; there is no glass."""
    x0, y0, x1, y1 = hole
    bar = lambda a, b, c, d, deep: shapes.box((a, b, -deep), (c, d, deep))
    parts = [bar(x0, y0, x0 + 0.06, y1, 0.05), bar(x1 - 0.06, y0, x1, y1, 0.05), bar(x0, y0, x1, y0 + 0.06, 0.048),
             bar(x0, y1 - 0.06, x1, y1, 0.048), bar(x0, y1 - 0.5, x1, y1 - 0.46, 0.03)]
    parts += [bar(x - 0.025, y0, x + 0.025, y1, 0.036) for x in np.linspace(x0, x1, panes + 1)[1:-1]]
    glb.add("window frame", shapes.joined(*parts), look["paint"], (0, 0, z))
    glb.add("sill", shapes.box((x0 - 0.06, y0 - 0.04, 0.0), (x1 + 0.06, y0 + 0.012, 0.19)), look["paint"], (0, 0, z))


def shell(glb, look):
    long, mid = EAST - WEST, MIDDLE - WEST
    shift = lambda hole: (hole[0] - WEST, hole[1], hole[2] - WEST, hole[3])
    holes = [shift(h) for h in (DOOR, WINDOW, DINING_WINDOW)]
    front = arch.pierced_wall(long, HIGH, WALL / 2, holes, 2.0)
    glb.add("front wall", front, look["wall"], (WEST, 0, -DEEP + WALL / 4))
    glb.add("front siding", front, look["siding"], (WEST, 0, -DEEP - WALL / 4))
    back = arch.pierced_wall(long, HIGH, WALL, [], 2.0)
    glb.add("back wall", back, look["wall"], (WEST, 0, DEEP))
    end = shapes.moved(arch.pierced_wall(2 * DEEP + WALL, HIGH, WALL, [], 2.0), turn_y=90)
    for x in (WEST - WALL / 2, EAST + WALL / 2):
        glb.add("end wall", end, look["wall"], (x, 0, DEEP + WALL / 2))
    between = arch.pierced_wall(2 * DEEP - WALL, HIGH, 0.14, [(1.4, 0, 3.2, 2.25)], 2.0)
    glb.add("wall between", between, look["wall"], (MIDDLE, 0, DEEP - WALL / 2), 90)
    corner = lambda y: np.array([WEST - WALL, y, DEEP + WALL / 2])
    across, inward = np.array([long + 2 * WALL, 0, 0]), np.array([0, 0, -2 * DEEP - WALL])
    glb.add("floor", shapes.quad(corner(0.001), across, inward, (5, 2.7)), look["boards"])
    glb.add("plinth", shapes.box((WEST - WALL, -0.3, -DEEP - WALL / 2), (EAST + WALL, 0, DEEP + WALL / 2)),
            look["wall"])
    glb.add("ceiling", shapes.box((WEST - WALL, HIGH, -DEEP - WALL / 2), (EAST + WALL, HIGH + 0.1, DEEP + WALL / 2)),
            look["ceiling"])
    for x in np.linspace(WEST + 0.7, EAST - 0.7, 8):
        glb.add("beam", shapes.box((x - 0.07, HIGH - 0.16, -DEEP + 0.12), (x + 0.07, HIGH + 0.01, DEEP - 0.12)),
                look["oak"])
    skirting = [((WEST, 0, DEEP - 0.14), (EAST, 0.11, DEEP - 0.1)),
                ((EAST - 0.02, 0, -DEEP + 0.12), (EAST + 0.01, 0.11, DEEP)),
                ((MIDDLE + 0.05, 0, -DEEP + 0.12), (MIDDLE + 0.09, 0.11, -0.72)),
                ((0.5, 0, -DEEP + 0.1), (EAST, 0.11, -DEEP + 0.14))]
    for low, high in skirting:
        glb.add("skirting", shapes.box(low, high), look["paint"])
    for hole, panes in ((WINDOW, 2), (DINING_WINDOW, 3)):
        window(glb, look, hole, -DEEP, panes)
    x0, _, x1, top = DOOR
    jambs = shapes.joined(shapes.box((x0, 0, -0.13), (x0 + 0.06, top, 0.13)),
                          shapes.box((x1 - 0.06, 0, -0.13), (x1, top, 0.13)),
                          shapes.box((x0, top - 0.06, -0.128), (x1, top, 0.128)))
    glb.add("door frame", jambs, look["paint"], (0, 0, -DEEP))
    width = (x1 - x0) / 2 - 0.08
    bars = [shapes.box((a, b, -0.02), (c, d, 0.02)) for a, b, c, d in (
        (0, 0.02, 0.09, 2.2), (width - 0.09, 0.02, width, 2.2), (0.09, 0.02, width - 0.09, 0.3),
        (0.09, 2.1, width - 0.09, 2.2), (0.09, 1.15, width - 0.09, 1.2), (0.09, 1.65, width - 0.09, 1.69))]
    leaf = shapes.joined(*bars, shapes.box((width / 2 - 0.02, 0.3, -0.017), (width / 2 + 0.02, 2.1, 0.017)))
    glb.add("door leaf", leaf, look["paint"], (x0 + 0.07, 0, -DEEP - 0.16), 105)
    glb.add("door leaf", leaf, look["paint"], (x1 - 0.07, 0, -DEEP - 0.16), 65)


def roof(glb, look):
    """A gable over the rooms, with a lower roof on posts over the veranda."""
    span, rise, length = DEEP + 0.5, 2.0, EAST - WEST + 1.2
    slope = np.degrees(np.arctan2(rise, span))
    slab = shapes.box((-length / 2, 0.02, -0.05), (length / 2, 0.1, np.hypot(rise, span)), 2.0)
    middle = (WEST + EAST) / 2
    for turn in (0, 180):
        glb.add("roof", shapes.turned(slab, slope), look["roof"], (middle, HIGH + rise, 0), turn)
    gable = shapes.mesh([(0, 0, DEEP), (0, 0, -DEEP), (0, rise * DEEP / span, 0)], [(0, 1, 2)], [(1, 0, 0)] * 3,
                        [(0, 2), (2, 2), (1, 0)])
    glb.add("gable", gable, look["siding"], (EAST + WALL, HIGH, 0))
    glb.add("gable", gable, look["siding"], (WEST - WALL, HIGH, 0), 180)
    porch = shapes.box((-length / 2, 0.0, 0.0), (length / 2, 0.07, PORCH + 0.1), 2.0)
    glb.add("veranda roof", shapes.turned(porch, 7), look["roof"], (middle, HIGH + 0.2, -DEEP - 0.02), 180)
    glb.add("deck", shapes.box((WEST - 0.2, -0.3, -DEEP - PORCH - 0.1), (EAST + 0.2, -0.04, -DEEP - 0.12), 1.2),
            look["deck"])
    glb.add("steps", shapes.box((-2.2, -0.3, -DEEP - PORCH - 0.45), (0, -0.17, -DEEP - PORCH - 0.1), 1.2), look["deck"])
    edge = -DEEP - PORCH  # the middle of its posts
    glb.add("veranda beam", shapes.box((WEST - 0.1, 2.5, edge - 0.07), (EAST + 0.1, 2.66, edge + 0.07)), look["paint"])
    posts = np.linspace(WEST, EAST, 5)
    for x in posts:
        glb.add("post", shapes.box((x - 0.06, -0.04, edge - 0.06), (x + 0.06, 2.5, edge + 0.06)), look["paint"])
    for a, b in ((posts[0], posts[1]), (posts[1], posts[2] - 0.4), (posts[3], posts[4])):
        rails = [shapes.box((a, y, -0.02), (b, y + 0.05, 0.02)) for y in (0.08, 0.78)]
        bars = [shapes.box((x - 0.015, 0.1, -0.01), (x + 0.015, 0.8, 0.01))
                for x in np.arange(a + 0.14, b - 0.05, 0.14)]
        glb.add("railing", shapes.joined(*rails, *bars), look["paint"], (0, 0, edge))


def living_room(glb, look, rng):
    glb.add("rug", shapes.box((-1.5, 0.002, -1.0), (1.5, 0.014, 1.0), 1.5), look["rug"], (0.2, 0, -0.25))
    sofa(glb, look, "sofa", 2.2, (2.55, 0.0, -0.4), -90, ((-0.6, "ochre"), (0.62, "rust")))
    sofa(glb, look, "armchair", 0.95, (-1.75, 0.0, -0.75), 70, ((0.0, "cream"),))
    glb.add("low table", plain_table(1.1, 0.6, 0.4), look["oak"], (0.65, 0.015, -0.4), 90)
    for i, (x, z, turn) in enumerate(((0.62, -0.15, 20), (0.64, -0.16, 32), (0.6, -0.14, 8))):
        glb.add("book", shapes.box((-0.13, 0, -0.09), (0.13, 0.028, 0.09)), look["books"][i],
                (x, 0.416 + 0.0285 * i, z), turn)
    bowl = shapes.lathe([(0, 0), (0.06, 0.0), (0.12, 0.035), (0.15, 0.085)], [(0.15, 0.085), (0.143, 0.086)],
                        [(0.143, 0.086), (0.112, 0.04), (0, 0.015)], segments=36)
    glb.add("bowl", bowl, look["clay"], (0.68, 0.416, -0.68))
    apple = cushion((0.075, 0.07, 0.075), 0.85, 10, 16)
    for x, y, z, which in ((0.65, 0.445, -0.68, "rust"), (0.72, 0.45, -0.65, "pale"), (0.7, 0.452, -0.73, "ochre")):
        glb.add("apple", apple, look[which], (x, y, z))
    full_bookcase(glb, look, (MIDDLE + 0.38, 0, 1.75), 90, rng)
    rod = swept([(-0.95, 0, 0), (0.95, 0, 0)], 0.014, 8)
    side = drape(0.5, 2.3, 5, 0.045, 16, 40, gather=0.25, seed=6)
    for x in (1.15, 2.9):
        glb.add("curtain", side, look["cream"], (x, 2.36, -DEEP + 0.2))
    glb.add("curtain rod", rod, look["iron"], (2.0, 2.38, -DEEP + 0.2))
    for x in (-2.95, 0.75):
        glb.add("curtain", side, look["cream"], (x, 2.46, -DEEP + 0.2))
    glb.add("curtain rod", swept([(-2.05, 0, 0), (2.05, 0, 0)], 0.014, 8), look["iron"], (-1.15, 2.48, -DEEP + 0.2))
    foot = shapes.lathe([(0.16, 0), (0.16, 0.02)], [(0.16, 0.02), (0.03, 0.035), (0.013, 0.06), (0.013, 1.5)],
                        segments=24)
    glb.add("lamp foot", foot, look["iron"], (2.75, 0, -2.0))
    glb.add("lamp shade", shapes.lathe([(0.23, 1.42), (0.15, 1.75)], segments=32), look["cream"], (2.75, 0, -2.0))
    pot = shapes.lathe([(0, 0), (0.13, 0)], [(0.13, 0), (0.19, 0.32)], [(0.19, 0.32), (0.2, 0.36), (0.18, 0.36)],
                       [(0.18, 0.36), (0.17, 0.31), (0, 0.31)], segments=28)
    twigs, tips = nature.branching(rng, 0.35, 0.018, levels=2, spread=0.6)
    plant = nature.crown(tips, rng, 10, 0.09, 0.24, nature.LOZENGE)
    for x, z in ((-2.8, -1.95), (0.85, -2.2)):
        glb.add("pot", pot, look["clay"], (x, 0, z))
        glb.add("twigs", twigs, look["bark"], (x, 0.3, z))
        glb.add("plant", plant, look["leaf"], (x, 0.3, z), 70 * x)
    for x, y, w, h, tint in ((3.27, 1.7, 0.7, 0.5, "ochre"), (3.27, 1.65, 0.4, 0.55, "wool")):
        z = -0.9 if tint == "ochre" else 0.1
        glb.add("picture frame", shapes.box((x - 0.03, y - h / 2, z - w / 2), (x + 0.04, y + h / 2, z + w / 2)),
                look["walnut"])
        glb.add("picture", shapes.quad((x - 0.032, y - h / 2 + 0.04, z - w / 2 + 0.04), (0, 0, w - 0.08),
                                       (0, h - 0.08, 0)), look[tint])


def dining_room(glb, look):
    at = (-5.15, 0, -0.5)
    glb.add("dining table", plain_table(0.9, 1.8, 0.75, 0.07), look["oak"], at)
    for dx, dz, turn in ((-0.65, -0.45, 90), (-0.65, 0.4, 84), (0.65, -0.4, -90), (0.72, 0.45, -80), (0.05, 1.2, 178)):
        glb.add("chair", plain_chair(), look["walnut"], (at[0] + dx, 0, at[2] + dz), turn)
    vase = shapes.lathe([(0, 0), (0.05, 0), (0.09, 0.08), (0.08, 0.16), (0.035, 0.22), (0.045, 0.25)], segments=28)
    glb.add("vase", vase, look["wool"], (at[0], 0.75, at[2] + 0.1))
    glb.add("sideboard", shapes.box((-6.95, 0.12, 0.6), (-6.5, 0.85, 2.2), 0.8), look["oak"])


def garden(glb, look, rng):
    glb.add("lawn", nature.ground(SKY_RADIUS, lambda x, z: -0.3 + 0.0 * x), look["lawn"])
    slab = shapes.box((-0.42, -0.3, -0.3), (0.42, -0.27, 0.3), 1.0)
    for k in range(10):
        glb.add("path", slab, look["wall"], (-1.1 + 0.3 * np.sin(k), 0, -5.1 - 0.72 * k), 8 * np.sin(3 * k))
    for i, (x, z, tall, spread, leaf) in enumerate(((-5.2, -9.5, 1.7, 0.8, "leaf"), (3.0, -8.8, 1.5, 0.75, "pale"),
                                                    (0.6, -12.5, 2.0, 0.8, "leaf"), (7.2, -6.0, 1.8, 0.8, "leaf"))):
        wood, tips = nature.branching(np.random.default_rng(20 + i), tall, 0.14, 3, spread=spread)
        glb.add("tree", wood, look["bark"], (x, -0.35, z))
        glb.add("crown", nature.crown(tips, rng, 8, 0.3, 0.36, nature.LOZENGE), look[leaf], (x, -0.35, z))
    hedge = nature.thicket((-2, 0, -0.5), (2, 1.5, 0.5), 1500, rng, 0.26, nature.LOZENGE)
    core = shapes.box((-1.97, 0, -0.47), (1.97, 1.46, 0.47))
    for k in range(5):
        glb.add("hedge", hedge, look["leaf"], (-8 + 4 * k, -0.3, -13.6 + 0.2 * (k % 2)))
        glb.add("hedge core", core, look["leaf"], (-8 + 4 * k, -0.3, -13.6 + 0.2 * (k % 2)))
    glb.add("bench seat", plain_table(1.5, 0.45, 0.44, 0.07), look["deck"], (2.4, -0.3, -7.4), -20)
    tuft = nature.tuft(rng, 12, 0.16)
    for x, z in rng.uniform((-6, -12.5), (5, -5.6), (160, 2)):
        if abs(x + 1.1) > 0.8:
            glb.add("tuft", tuft, look["pale"], (x, -0.3, z), rng.uniform(0, 360), rng.uniform(0.7, 1.6))
    glb.add("sky", nature.dome(SKY_RADIUS, -0.6, 6, 24),
            lit(glb, "sky", 3.2, picture=sky([0.34, 0.54, 0.9], [0.82, 0.88, 0.96], 64)))
    toward = SUN / np.linalg.norm(SUN)
    scene.sun_disc(glb, toward * (SKY_RADIUS - 1.3), -toward, 0.14, 60.0, (1.0, 0.88, 0.7))


def main():
    glb = scene.begin("house", (640, 360))
    look, rng = looks(glb), np.random.default_rng(12)
    shell(glb, look)
    roof(glb, look)
    living_room(glb, look, rng)
    dining_room(glb, look)
    garden(glb, look, rng)
    glb.camera("living room", (1.15, 1.5, 2.42), (-0.35, 1.1, -1.7), 56)
    glb.camera("garden", (-2.6, 1.3, -9.3), (-1.7, 1.35, -2.6), 60)
    scene.save(glb)


if __name__ == "__main__":
    main()
