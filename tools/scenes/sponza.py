#!/usr/bin/env python3
"""Makes scenes/sponza.glb: a courtyard with arcades in two storeys, after the well-known atrium. Sky and a
little sun come in from above; the camera stands in the gallery, where nearly all light has been reflected off the
court, its walls and the cloths that hang there: many surfaces matter, each to other parts of the picture. Wholly
Lambert.

    python3 tools/scenes/sponza.py [OUT.glb]
"""

import numpy as np

import architecture as arch
import household
import nature
import scene
import shapes
from forms import swept
from looks import lit, matte, printed
from pictures import blocks, cloudy, damask, planks

BAY, THICK, GALLERY = 2.8, 0.45, 3.0
COURT = np.array([1.5 * BAY, 3 * BAY])  # half extents to the middle of the arcade's wall, x and z
OUTER = COURT + GALLERY
SPRING, FLOOR = 2.9, 4.8
UPPER_SPRING, ROOF, TOP = 2.15, 8.5, 9.5
SUN_GAP = 2.6
SIDES = ((0, COURT[1], 3), (90, COURT[0], 6), (180, COURT[1], 3), (270, COURT[0], 6))  # turn, distance, bays


def placed(turn, x, y, z):
    """A point of a side's own frame (+z to the outside) in the world."""
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    return (c * x + s * z, y, c * z - s * x)


def looks(glb):
    stone = blocks([0.72, 0.64, 0.52], [0.58, 0.49, 0.38], [0.45, 0.38, 0.3], 4, 3, seed=5, gap=0.01)
    slabs = blocks([0.7, 0.63, 0.54], [0.54, 0.47, 0.39], [0.32, 0.28, 0.24], 4, 4, seed=8, gap=0.01, shift=0)
    return dict(
        stone=printed(glb, "stone blocks", stone),
        slabs=printed(glb, "floor slabs", slabs),
        plaster=printed(glb, "plaster", cloudy([0.84, 0.77, 0.66], [0.72, 0.64, 0.52], seed=2)),
        carved=matte(glb, "carved stone", (0.56, 0.47, 0.36)),
        leaf=matte(glb, "capital leaves", (0.56, 0.47, 0.36), doubleSided=True),
        wood=printed(glb, "old oak", planks([0.42, 0.26, 0.15], [0.26, 0.15, 0.08], seed=4)),
        iron=matte(glb, "iron", (0.06, 0.055, 0.05)),
        clay=matte(glb, "clay", (0.52, 0.23, 0.13)),
        green=matte(glb, "box tree", (0.09, 0.2, 0.05), doubleSided=True))


def shell(glb, look):
    x, z = COURT
    inset = np.array([THICK, THICK]) / 2
    glb.add("court floor", shapes.quad((-x, -0.15, z), (2 * x, 0, 0), (0, 0, -2 * z), (x, z)), look["slabs"])
    glb.add("gallery floor", arch.frame(COURT - 0.45, OUTER, -0.15, 0.0, 2.0), look["slabs"])
    glb.add("upper floor", arch.frame(COURT - 0.32, OUTER, FLOOR - 0.3, FLOOR, 2.0), look["slabs"])
    glb.add("outer wall", arch.frame(OUTER, OUTER + 0.3, -0.2, TOP, 2.0), look["stone"])
    glb.add("ceiling", arch.frame(COURT - inset, OUTER, ROOF, ROOF + 0.2, 2.0), look["wood"])
    glb.add("parapet", arch.frame(COURT - inset, COURT + inset, ROOF + 0.2, TOP, 2.0), look["plaster"])
    profile = lambda y: [(y, y + 0.1, 0.1), (y + 0.1, y + 0.18, 0.17), (y + 0.18, y + 0.3, 0.26)]
    for turn, distance, bays in SIDES:
        length = bays * BAY - 0.6
        cornice = arch.steps_of(profile(0.0), length)
        for y in (FLOOR - 0.62, ROOF):
            glb.add("cornice", cornice, look["carved"], placed(turn, 0, y, distance - THICK / 2), turn + 180)
    for sx in (-1, 1):
        for sz in (-1, 1):
            at = (sx * COURT[0], 0, sz * COURT[1])
            glb.add("corner pier", shapes.box((-0.36, -0.15, -0.36), (0.36, ROOF, 0.36), 2.0), look["stone"], at)


def arcades(glb, look):
    lower = arch.arch_panel(BAY, FLOOR - 0.3, 1.05, SPRING, THICK, 2.0)
    upper = arch.arch_panel(BAY, ROOF, 1.1, FLOOR + UPPER_SPRING, THICK, 2.0)
    band, upper_band = arch.archivolt(1.05, SPRING, 0.22, 0.05), arch.archivolt(1.1, FLOOR + UPPER_SPRING, 0.16, 0.04)
    column, upper_column = arch.column(SPRING, 0.23), arch.column(UPPER_SPRING, 0.15, 16)
    leaves, upper_leaves = arch.leafy_collar(0.21, 0.46), arch.leafy_collar(0.135, 0.3)
    baluster = arch.baluster(0.72, 0.062)
    rail = shapes.joined(shapes.box((-BAY / 2, 0.8, -0.1), (BAY / 2, 0.92, 0.1)),
                         shapes.box((-BAY / 2, 0.0, -0.09), (BAY / 2, 0.08, 0.09)))
    for turn, distance, bays in SIDES:
        for k in range(bays):
            x = (k - (bays - 1) / 2) * BAY
            at = placed(turn, x, 0, distance)
            glb.add("arch", lower, look["plaster"], at, turn)
            glb.add("upper arch", upper, look["plaster"], at, turn)
            for z, facing in ((-THICK / 2, 180), (THICK / 2, 0)):
                glb.add("archivolt", band, look["carved"], placed(turn, x, 0, distance + z), turn + facing)
                glb.add("upper archivolt", upper_band, look["carved"], placed(turn, x, 0, distance + z), turn + facing)
            glb.add("rail", rail, look["carved"], placed(turn, x, FLOOR, distance), turn)
            for i in range(6):
                glb.add("baluster", baluster, look["carved"],
                        placed(turn, x + (i - 2.5) * 0.38, FLOOR + 0.08, distance))
            if k:  # the corners have piers
                foot = placed(turn, x - BAY / 2, 0, distance)
                glb.add("column", column, look["carved"], foot, turn)
                glb.add("capital", leaves, look["leaf"], (foot[0], SPRING - 0.55, foot[2]))
                glb.add("upper column", upper_column, look["carved"], (foot[0], FLOOR, foot[2]), turn)
                glb.add("upper capital", upper_leaves, look["leaf"], (foot[0], FLOOR + UPPER_SPRING - 0.36, foot[2]))


def galleries(glb, look):
    deep = GALLERY - THICK / 2
    middle = THICK / 2 + deep / 2
    vault, corner = arch.groin_vault(BAY, deep, 1.3, tiles=2.0), arch.groin_vault(deep, deep, 1.3, tiles=2.0)
    a = np.linspace(0, np.pi, 21)
    rib = swept(np.stack([0 * a, 1.3 * np.sin(a), deep / 2 * np.cos(a)], 1), 0.1, 6, capped=False)
    pilaster = shapes.joined(shapes.box((-0.2, 0, -0.16), (0.2, SPRING - 0.2, 0.0)),
                             shapes.box((-0.26, 0, -0.22), (0.26, 0.3, 0.0)),
                             shapes.box((-0.26, SPRING - 0.2, -0.24), (0.26, SPRING, 0.0)))
    beam = shapes.box((-0.09, ROOF - 0.22, -deep / 2), (0.09, ROOF + 0.02, deep / 2))
    doorway = shapes.joined(shapes.box((-0.75, 0, -0.12), (-0.58, 2.2, 0)),
                            shapes.box((0.58, 0, -0.12), (0.75, 2.2, 0)),
                            shapes.box((-0.85, 2.2, -0.16), (0.85, 2.42, 0)))
    door = shapes.box((-0.58, 0, -0.05), (0.58, 2.2, 0))
    door["uvs"] = door["uvs"][:, ::-1].copy()
    for turn, distance, bays in SIDES:
        for k in range(bays):
            x = (k - (bays - 1) / 2) * BAY
            glb.add("vault", vault, look["plaster"], placed(turn, x, SPRING, distance + middle), turn)
            wall = placed(turn, x, 0, distance + GALLERY)
            if (k + turn // 90) % 2:
                glb.add("doorway", doorway, look["carved"], wall, turn)
                glb.add("door", door, look["wood"], wall, turn)
            for i in range(4):
                glb.add("beam", beam, look["wood"], placed(turn, x + (i - 1.5) * 0.7, 0, distance + middle), turn)
        for k in range(bays + 1):
            x = (k - bays / 2) * BAY
            glb.add("rib", rib, look["carved"], placed(turn, x, SPRING, distance + middle), turn)
            glb.add("pilaster", pilaster, look["carved"], placed(turn, x, 0, distance + GALLERY), turn)
        at = placed(turn, (bays * BAY + GALLERY + THICK / 2) / 2, SPRING, distance + middle)
        glb.add("corner vault", corner, look["plaster"], at, turn)


def cloths(glb):
    """Curtains in the lower arches, drawn aside or let down, and banners over the upper rail."""
    dyes = [printed(glb, name, damask(*colors), doubleSided=True) for name, colors in (
        ("madder", ([0.62, 0.07, 0.06], [0.72, 0.2, 0.1], [0.85, 0.62, 0.2])),
        ("woad", ([0.07, 0.16, 0.42], [0.14, 0.28, 0.55], [0.8, 0.7, 0.4])),
        ("weld", ([0.16, 0.34, 0.14], [0.28, 0.45, 0.18], [0.82, 0.66, 0.25])))]
    curtains = [household.drape(1.9, 2.75, 5, 0.07, 14, 50, seed=1),
                household.drape(0.75, 2.7, 5, 0.05, 16, 30, gather=0.55, seed=2)]
    banner = household.drape(1.3, 2.6, 2, 0.035, 10, 24, seed=3)
    rod = swept([(-1.05, 0, 0), (1.05, 0, 0)], 0.022, 8)
    brass = matte(glb, "rod", (0.2, 0.14, 0.06))
    for turn, k, kind, dye in ((90, 1, 1, 0), (90, 3, 0, 2), (270, 0, 0, 1), (270, 2, 1, 0), (270, 3, 0, 0),
                               (270, 5, 1, 2), (180, 1, 0, 1), (90, 5, 1, 1), (0, 1, 1, 2)):
        _, distance, bays = SIDES[turn // 90]
        x = (k - (bays - 1) / 2) * BAY
        glb.add("curtain rod", rod, brass, placed(turn, x, SPRING + 0.02, distance), turn)
        for side in (-1, 1) if kind else (0,):
            at = placed(turn, x + 0.62 * side, SPRING, distance)
            glb.add("curtain", curtains[kind], dyes[dye], at, turn + (180 if side > 0 else 0))
    for turn, k, dye in ((270, 1, 2), (270, 4, 1), (180, 0, 0), (180, 2, 2), (90, 2, 1), (0, 0, 0)):
        _, distance, bays = SIDES[turn // 90]
        x = (k - (bays - 1) / 2) * BAY
        glb.add("banner", banner, dyes[dye], placed(turn, x, FLOOR + 0.86, distance - 0.38), turn)


def court(glb, look):
    """A well in the middle, tubs with clipped trees, jars along the galleries."""
    well = shapes.lathe([(0.95, 0), (0.95, 0.12)], [(0.95, 0.12), (0.72, 0.12)],
                        [(0.72, 0.12), (0.7, 0.2), (0.7, 0.75), (0.74, 0.8)], [(0.74, 0.8), (0.82, 0.84), (0.8, 0.94)],
                        [(0.8, 0.94), (0.58, 0.94)], [(0.58, 0.94), (0.56, 0.5), (0.56, 0.1), (0.0, 0.1)])
    glb.add("well", well, look["carved"], (0, -0.15, -1.2))
    hoop = [(0.7 * np.cos(t), 0.9 + 1.25 * np.sin(t), 0) for t in np.linspace(0, np.pi, 25)]
    glb.add("hoop", swept(hoop, 0.025, 8), look["iron"], (0, -0.15, -1.2), 35)
    jar = shapes.lathe([(0.0, 0), (0.14, 0.0)], [(0.14, 0.0), (0.2, 0.1), (0.27, 0.3), (0.29, 0.48), (0.25, 0.66),
                                                 (0.16, 0.78), (0.13, 0.84), (0.17, 0.9)],
                       [(0.17, 0.9), (0.14, 0.9), (0.11, 0.84), (0.0, 0.7)], segments=28)
    tub = shapes.lathe([(0.24, 0.0), (0.32, 0.44)], [(0.32, 0.44), (0.34, 0.46), (0.34, 0.52), (0.3, 0.52)],
                       [(0.3, 0.52), (0.28, 0.46), (0.0, 0.46)], segments=28)
    rng = np.random.default_rng(9)
    n = rng.normal(size=(900, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    crown = nature.cards(n * rng.uniform(0.3, 0.42, (900, 1)), n + rng.normal(size=n.shape) * 0.4, np.full(900, 0.12),
                         rng, nature.LOZENGE)
    trunk = swept([(0, 0.4, 0), (0.02, 0.8, 0.01), (0, 1.2, 0)], 0.03, 8)
    for x, z in ((-2.6, 2.4), (2.6, 2.6), (-2.6, -4.4), (2.6, -4.6)):
        glb.add("tub", tub, look["clay"], (x, -0.15, z))
        glb.add("trunk", trunk, look["wood"], (x, -0.15, z))
        glb.add("crown", crown, look["green"], (x, 1.32, z), turn_y=40 * x * z)
    for x, z, size in ((6.7, 2.9, 1), (6.75, 2.2, 0.75), (6.7, -2.6, 1.1), (-6.6, 0.2, 1), (6.6, 5.6, 0.9),
                       (4.95, -6.9, 0.9)):
        glb.add("jar", jar, look["clay"], (x, 0, z), 30 * x, size)
    bench = shapes.joined(shapes.box((-0.9, 0.38, -0.22), (0.9, 0.46, 0.22)),
                          *(shapes.box((x - 0.08, 0, -0.18), (x + 0.08, 0.38, 0.18)) for x in (-0.65, 0.65)))
    for x, z, turn in ((6.85, -0.0, 90), (6.85, -5.6, 90), (-6.85, 4.2, 90), (-1.5, 10.9, 0)):
        glb.add("bench", bench, look["carved"], (x, 0, z), turn)


def light(glb):
    """Sky over most of the opening; the sun comes in where it ends. What the camera sees through that gap is a small
    piece of sky behind the far parapet."""
    x, z = COURT - THICK / 2
    sky = lit(glb, "sky", 9.0, (0.72, 0.86, 1.0))
    glb.add("sky", shapes.quad((SUN_GAP - x, TOP, -z), (2 * x - SUN_GAP, 0, 0), (0, 0, 2 * z)), sky)
    far = lit(glb, "far sky", 2.5, (0.72, 0.86, 1.0))
    glb.add("far sky", shapes.quad((-2 * x, TOP, -z - THICK), (1.6 * x, 0, 0), (0, 8.0, 0)), far)
    scene.sun(glb, (0.6, -0.8, -0.1), 30.0, (1.0, 0.86, 0.66))


def main():
    glb = scene.begin("sponza", (640, 360))
    look = looks(glb)
    shell(glb, look)
    arcades(glb, look)
    galleries(glb, look)
    cloths(glb)
    court(glb, look)
    light(glb)
    glb.camera("gallery", (6.35, 1.65, 7.3), (3.0, 2.3, -3.0), 54)
    scene.save(glb)


if __name__ == "__main__":
    main()
