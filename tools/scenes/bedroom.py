#!/usr/bin/env python3
"""Makes scenes/bedroom.glb: a bedroom in the morning, its blinds down against the sun, two small lamps still on.

The slats hide nearly all of the sky; what comes in was scattered between them, or fell through the gap where the
curtain is drawn aside. The lamps' bulbs are the size of a plum, in opaque shades. Many surfaces, each lit by few and
different lights. All surfaces are Lambertian.

    python3 tools/scenes/bedroom.py [OUT.glb]
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

LEFT, RIGHT, BACK, FRONT, HIGH = -2.3, 2.2, 0.0, 4.3, 2.6
WINDOWS = ((0.55, 1.75), (2.15, 3.35))  # in the left wall, by z
SILL, LINTEL = 0.85, 2.2
BED = (-0.25, 1.62, 2.05)  # its middle's x, its width and length; the head is at the back wall


def materials(glb):
    boards = pictures.boards(320, 8, (0.72, 0.55, 0.38), (0.56, 0.4, 0.25), 21)
    rug = pictures.carpet(288, 192, (0.8, 0.74, 0.62), (0.3, 0.4, 0.5), (0.72, 0.4, 0.3), 6)
    x, y = pictures.plane(96, 96)
    plaid = (np.abs(x * 4 % 1 - 0.5) < 0.16).astype(float) * 0.5 + (np.abs(y * 4 % 1 - 0.5) < 0.16) * 0.5
    plaid = pictures.blend([0.3, 0.42, 0.5], [0.82, 0.8, 0.72], plaid)
    grain = pictures.few(pictures.wood(192, 96, [0.66, 0.47, 0.3], [0.5, 0.33, 0.19], 5))
    m = {name: printed(glb, name, image) for name, image in dict(
        floor=boards, rug=rug, grain=grain).items()}
    m["throw"] = printed(glb, "throw", plaid, doubleSided=True)
    for name, color in dict(
            wall=(0.72, 0.74, 0.76), feature=(0.48, 0.58, 0.62), ceiling=(0.86, 0.85, 0.83), white=(0.85, 0.84, 0.81),
            oak=(0.56, 0.39, 0.23), walnut=(0.32, 0.19, 0.11), slats=(0.84, 0.82, 0.76), metal=(0.5, 0.46, 0.38),
            linen=(0.86, 0.83, 0.77), pillow=(0.88, 0.87, 0.85), teal=(0.16, 0.36, 0.38), rust=(0.62, 0.27, 0.15),
            mustard=(0.75, 0.55, 0.16), navy=(0.12, 0.17, 0.32), plum=(0.35, 0.12, 0.22), sage=(0.45, 0.52, 0.4),
            black=(0.06, 0.06, 0.06), clay=(0.68, 0.36, 0.22), earth=(0.1, 0.07, 0.05), pages=(0.84, 0.79, 0.68),
            stone=(0.55, 0.53, 0.5)).items():
        m[name] = matte(glb, name, color)
    for name, color in dict(leaves=(0.18, 0.38, 0.14), curtain=(0.74, 0.66, 0.52), duvet=(0.86, 0.84, 0.8)).items():
        m[name] = matte(glb, name, color, doubleSided=True)
    return m


def house(glb, m):
    holes = [(a, b, SILL, LINTEL) for a, b in WINDOWS]
    walls = arch.room(LEFT, RIGHT, BACK, FRONT, HIGH, 0.2, left=holes)
    place(glb, "wall", walls, dict.fromkeys(walls, m["wall"]) | dict(back=m["feature"]))
    glb.add("floor", shapes.box((LEFT - 0.1, -0.1, BACK - 0.1), (RIGHT + 0.1, 0, FRONT + 0.1), 1.7), m["floor"])
    glb.add("ceiling", shapes.box((LEFT - 0.1, HIGH, BACK - 0.1), (RIGHT + 0.1, HIGH + 0.1, FRONT + 0.1)), m["ceiling"])
    for name, length, at, turn in (("back", RIGHT - LEFT, (LEFT, 0, BACK), 0), ("left", FRONT, (LEFT, 0, FRONT), 90),
                                   ("right", FRONT, (RIGHT, 0, BACK), -90)):
        glb.add(f"{name} skirting", arch.skirting(length, 0.1), m["white"], at, turn)
        cornice = shapes.bars((0, length, HIGH - 0.07, HIGH, -0.005, 0.07))
        glb.add(f"{name} cornice", cornice, m["white"], at, turn)
    frame = arch.door_frame(0.9, 2.06, 0.05)
    place(glb, "door frame", frame, dict(frame=m["white"]), (RIGHT - 0.001, 0, 2.95), -90)
    place(glb, "door", arch.door_leaf(), dict(door=m["white"], metal=m["metal"]), (RIGHT, 0.01, 2.97), -90)


def windows(glb, m):
    """Frames, sills, blinds with real slats, curtains; outside a sky and a low sun, both as surfaces."""
    wide, high = WINDOWS[0][1] - WINDOWS[0][0], LINTEL - SILL
    frame = arch.window_frame(wide, high, 0.16)
    sill = shapes.flat(shapes.box((-0.05, -0.035, -0.02), (wide + 0.05, 0.0, 0.12)))
    for i, (low, top) in enumerate(WINDOWS):
        at = (LEFT, SILL, top)
        place(glb, f"window {i + 1}", frame, dict(frame=m["white"]), at, 90)
        glb.add(f"sill {i + 1}", sill, m["white"], at, 90)
        up = (0.01, 0.24)[i]  # the blind by the armchair is drawn up a little and lets the sun in below
        blind = household.blind(wide - 0.02, high - 0.01 - up, 0.036, 0.05, -46)
        place(glb, f"blind {i + 1}", blind, dict(slats=m["slats"], rails=m["slats"]),
              (LEFT + 0.03, SILL + up, (low + top) / 2), 90)
    for i, (z, width, gather) in enumerate(((0.38, 0.62, 0.0), (1.95, 0.6, 0.3), (3.55, 0.6, 0.2))):
        cloth = household.curtain(width, 2.34, 5, seed=i + 1, gather=gather)
        place(glb, f"curtain {i + 1}", cloth, dict(cloth=m["curtain"]), (LEFT + 0.14, 0.015, z), 90)
    rod = forms.pipe([(LEFT + 0.14, 2.38, 0.02), (LEFT + 0.14, 2.38, 3.95)], 0.014, 10)
    glb.add("curtain rod", rod, m["walnut"])
    holders = shapes.bars(*((LEFT - 0.01, LEFT + 0.15, 2.375, 2.385, z, z + 0.02) for z in (0.05, 1.93, 3.9)))
    glb.add("rod holders", holders, m["walnut"])

    sky = glowing(glb, "sky", 26, color=(0.62, 0.8, 1.0))
    glb.add("sky", shapes.quad((LEFT - 5, -0.2, 9), (0, 0, -14), (0, 8, 0)), sky)
    glb.add("ground", shapes.box((LEFT - 5, -0.3, -5), (LEFT - 0.25, -0.1, 9)), m["sage"])
    sun = glowing(glb, "sun", 4000, color=(1.0, 0.82, 0.6))
    glb.add("sun", shapes.quad((LEFT - 3.9, 3.6, 4.9), (0, 0, -0.5), (0.2, 0.4, 0)), sun)


def duvet(width, length, thick, seed, turn_down=0.0):
    """A quilt over a bed about x = 0, from z = 0 at its upper end; y = 0 is the mattress's top. It hangs over the
    sides and the foot; folds run where a sleeper turned."""
    rng = np.random.default_rng(seed)
    waves = [(rng.uniform(3, 13), rng.uniform(0, np.pi), rng.uniform(0, 6)) for _ in range(14)]

    def point(s, t):
        over = 0.26
        a, b = (2 * s - 1) * (width / 2 + over), t * (length + over)
        fold = sum(np.sin(k * (a * np.cos(w) + b * np.sin(w)) + p + 0.6 * np.sin(2.3 * a + p)) / k**0.7
                   for k, w, p in waves) * 0.02
        ridge = 0.03 * np.exp(-((a - 0.25 - 0.3 * np.sin(2 * b)) / 0.09) ** 2) * np.sin(np.pi * t)
        side, foot = np.maximum(np.abs(a) - width / 2, 0), np.maximum(b - length, 0)
        flop = 0.035 * np.sin(7 * b + 2 * np.sign(a)) * side / over + 0.03 * np.sin(8 * a) * foot / over
        x = np.clip(a, -width / 2, width / 2) + np.sign(a) * np.minimum(side, 0.06) + np.sign(a) * flop * (side > 0)
        z = np.minimum(b, length) + np.minimum(foot, 0.06) + flop * (foot > 0)
        round_ = thick * np.minimum(1, np.minimum(t * 14, 1.0)) ** 0.5
        y = round_ + fold + ridge - 1.15 * np.maximum(np.maximum(side, foot) - 0.03, 0)
        hanging = np.clip((side + foot) / 0.1, 0, 1)
        return x, np.maximum(y, 0.004) * (1 - hanging) + y * hanging, z
    return forms.surface(point, 64, 60)


def bed(glb, m):
    x, wide, long_ = BED
    w, top, z = wide / 2, 0.5, 0.1
    legs = [(sx * (w - 0.06) - 0.04, sx * (w - 0.06) + 0.04, 0, 0.14, a, a + 0.08) for sx in (-1, 1)
            for a in (z + 0.1, z + long_ - 0.1)]
    frame = shapes.bars((-w - 0.03, w + 0.03, 0.14, 0.3, z, z + long_ + 0.03), *legs)
    glb.add("bed frame", frame, m["walnut"], (x, 0, 0))
    posts = [shapes.rounded((a, 0.0, 0.02), (b, c, 0.09), 0.012) for a, b, c in ((-w - 0.05, -w + 0.02, 1.12),
                                                                                 (w - 0.02, w + 0.05, 1.12))]
    slats = [shapes.box((a - 0.03, 0.42, 0.04), (a + 0.03, 1.02, 0.065)) for a in np.linspace(-w + 0.12, w - 0.12, 9)]
    rails = [shapes.rounded((-w, y - 0.04, 0.03), (w, y + 0.04, 0.08), 0.012) for y in (0.45, 1.04)]
    glb.add("headboard", shapes.flat(*posts, *slats, *rails), m["walnut"], (x, 0, 0))
    glb.add("mattress", shapes.rounded((-w, 0.28, z), (w, top, z + long_), 0.05, 2), m["linen"], (x, 0, 0))
    glb.add("duvet", duvet(wide, long_ - 0.62, 0.075, 3), m["duvet"], (x, top, z + 0.6))
    glb.add("throw", throw(wide), m["throw"], (x, top + 0.118, z + long_ - 0.62))
    big, small = household.pillow(0.72, 0.48, 0.17), household.pillow(0.44, 0.44, 0.16)
    for i, (dx, y, dz, turn, angle, mesh, color) in enumerate((
            (-0.4, top - 0.01, 0.36, 4, 14, big, "pillow"), (0.4, top - 0.01, 0.34, -6, 12, big, "pillow"),
            (-0.36, top + 0.21, 0.26, -3, 62, big, "sage"), (0.36, top + 0.22, 0.27, 5, 60, big, "sage"),
            (0.06, top + 0.2, 0.49, 9, 58, small, "rust"))):
        glb.add(f"pillow {i + 1}", shapes.turned(mesh, angle), m[color], (x + dx, y, z + dz), turn)


def throw(wide):
    """A blanket laid over the foot of the bed, a little askew."""
    def point(s, t):
        a, b = (2 * s - 1) * (wide / 2 + 0.3), (t - 0.5) * 0.55
        over = np.maximum(np.abs(a) - wide / 2, 0)
        fold = 0.012 * np.sin(9 * a + 3 * b) + 0.01 * np.sin(21 * b + 4 * a)
        x = np.clip(a, -wide / 2, wide / 2) + np.sign(a) * (
            np.minimum(over, 0.11) + 0.012 * np.sin(30 * b) * (over > 0))
        return x, 0.035 + fold - np.maximum(over - 0.06, 0) * 1.2, b + 0.1 * a + 0.03 * np.sin(4 * a)
    return forms.surface(point, 54, 22, (4, 1))


def lamps(glb, m):
    bulb = glowing(glb, "bulb", 1500, color=(1.0, 0.68, 0.36))
    stand = furniture.cabinet(0.46, 0.52, 0.38, 1, (1, 1.4), legs=0.14)
    lamp = lighting.table_lamp(0.44, 0.13, 0.02)
    wear = dict(body=m["walnut"], fronts=m["walnut"], top=m["grain"], metal=m["metal"])
    for i, (dx, foot) in enumerate(((-1.16, "teal"), (1.16, "clay"))):
        x = BED[0] + dx
        place(glb, f"night stand {i + 1}", stand, wear, (x, 0, 0.02))
        place(glb, f"lamp {i + 1}", lamp, dict(foot=m[foot], shade=m["linen"], lining=m["white"], bulb=bulb),
              (x + 0.04 * dx, 0.545, 0.2))
    off = lighting.pendant(0.5, 0.26, 0.2)
    place(glb, "ceiling lamp", off, dict(metal=m["metal"], shade=m["linen"], lining=m["white"], bulb=m["white"]),
          (0.0, HIGH, 2.2))


def furnishings(glb, m):
    rng = np.random.default_rng(31)
    glb.add("rug", household.rug(2.7, 1.8, 0.014), m["rug"], (-0.15, 0, 2.75), -4)
    names = ("teal", "rust", "mustard", "navy", "plum", "sage", "black", "clay")
    covers = household.covers(m, *names)
    shelf, levels = furniture.shelf(0.96, 2.05, 0.3, 6)
    place(glb, "bookcase", shelf, dict(wood=m["oak"]), (1.69, 0, 0.02))
    for i, level in enumerate(levels):
        row = household.books(0.91, 0.29, 0.26, rng, len(names), rng.uniform(0.55, 0.95))
        place(glb, f"books {i + 1}", row, covers, (1.235, level, 0.03))
    place(glb, "books on top", household.book_pile(4, rng, 8), covers, (1.48, 2.05, 0.18), 10)
    glb.add("jar", tableware.vase([(0.06, 0), (0.1, 0.08), (0.07, 0.2), (0.05, 0.24), (0.07, 0.27)]), m["clay"],
            (1.9, 2.05, 0.17))
    place(glb, "night books", household.book_pile(3, rng, 8), covers, (BED[0] - 1.06, 0.545, 0.33), 15)
    mug = tableware.mug()
    glb.add("mug", mug, m["teal"], (BED[0] + 1.03, 0.545, 0.34), 60)
    clock = shapes.bars((-0.05, 0.05, 0, 0.07, -0.03, 0.03))
    glb.add("clock", clock, m["black"], (BED[0] + 1.3, 0.545, 0.3), -20)

    place(glb, "armchair", furniture.armchair(), dict(cloth=m["mustard"], pad=m["linen"], wood=m["walnut"]),
          (-1.62, 0, 2.45), 122)
    chest = furniture.cabinet(1.1, 0.85, 0.46, 2, (1, 1, 1, 1))
    place(glb, "chest", chest, dict(body=m["white"], fronts=m["white"], top=m["grain"], metal=m["metal"]),
          (RIGHT, 0, 1.15), -90)
    place(glb, "plant", nature.plant(rng, 38, 0.48, (0.15, 0.3)), dict(
        pot=m["stone"], earth=m["earth"], leaves=m["leaves"]), (-1.88, 0, 0.55))
    place(glb, "small plant", nature.plant(rng, 24, 0.2, (0.06, 0.1)), dict(
        pot=m["clay"], earth=m["earth"], leaves=m["leaves"]), (RIGHT - 0.22, 0.875, 0.82))
    glb.add("dish", tableware.bowl(0.08, 0.04), m["teal"], (RIGHT - 0.2, 0.875, 1.2))
    shoe = household.shoe(0.26)
    for i, (x, z, turn) in enumerate(((-0.92, 1.72, 150), (-0.8, 1.84, 118))):
        glb.add(f"slipper {i + 1}", shoe, m["plum"], (x, 0.014 if z > 1.8 else 0.001, z), turn)
    bench = shapes.joined(shapes.rounded((-0.6, 0.36, -0.2), (0.6, 0.46, 0.2), 0.03, 2))
    glb.add("bench", bench, m["teal"], (-0.1, 0, 2.58), 3)
    legs = shapes.bars(*((x - 0.02, x + 0.02, 0, 0.37, z - 0.02, z + 0.02) for x in (-0.52, 0.52)
                         for z in (-0.15, 0.15)))
    glb.add("bench legs", legs, m["walnut"], (-0.1, 0, 2.58), 3)
    place(glb, "books on the bench", household.book_pile(2, rng, 8), covers, (-0.4, 0.46, 2.59), 30)


def hang(glb, m):
    art = ((0.75, 0.35, 0.2), (0.2, 0.35, 0.45), (0.85, 0.65, 0.3), (0.25, 0.2, 0.2))
    prints = (("coast", pictures.landscape(192, 128, 5, ((0.6, 0.72, 0.85), (0.96, 0.9, 0.8)), (0.2, 0.33, 0.38)),
               0.8, 0.56, "oak", (BED[0], 1.65, BACK), 0),
              ("leaf", pictures.botanical(96, 128, 2), 0.34, 0.44, "black", (BED[0] - 0.74, 1.66, BACK), 0),
              ("twig", pictures.botanical(96, 128, 5), 0.34, 0.44, "black", (BED[0] + 0.8, 1.64, BACK), 0),
              ("forms", pictures.abstract(96, 128, 4, art), 0.46, 0.6, "oak", (RIGHT, 1.6, 1.15), -90))
    for name, image, width, height, frame, at, turn in prints:
        wear = dict(frame=m[frame], mat=m["white"], print=printed(glb, name, image))
        place(glb, name, household.picture(width, height, 0.025, 0.055), wear, at, turn)


def main():
    glb = scene.begin("bedroom", (640, 360))
    m = materials(glb)
    for part in (house, windows, bed, lamps, furnishings, hang):
        part(glb, m)
    glb.camera("bed", (1.45, 1.5, 4.15), (-0.3, 0.86, 0.9), 48)
    scene.save(glb)


if __name__ == "__main__":
    main()
