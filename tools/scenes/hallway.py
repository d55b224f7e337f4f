#!/usr/bin/env python3
"""Makes scenes/hallway.glb: a long hallway at night, lit from niches, side rooms and around its far corner.

No lamp can be seen, and hardly a wall that one shines at: most of the picture gets its light after three bounces and
more, a piece of the hallway from each of five places. Paths must be joined near the right doorway, which differs from
place to place. All surfaces are Lambertian.

    python3 tools/scenes/hallway.py [OUT.glb]
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

HALF, HIGH, NEAR, FAR, THICK = 0.95, 2.6, 1.6, -12.6, 0.12  # half the hallway's width, its height, its ends
DOOR = 2.06  # an opening's height
# Openings in the left and right wall, by their z; a name for each, as some lead to rooms and some have closed doors.
LEFT = dict(closed=(-2.0, -1.1), niche=(-4.7, -3.3), ajar=(-8.4, -7.5), corner=(-12.5, -11.1))
RIGHT = dict(near=(0.1, 1.0), closed=(-3.9, -3.0), open=(-7.1, -6.2), last=(-10.6, -9.7))


def materials(glb):
    boards = glb.texture("boards", pictures.boards(320, 7, (0.62, 0.43, 0.27), (0.44, 0.28, 0.15), 8))
    runner = pictures.carpet(96, 384, (0.62, 0.2, 0.15), (0.2, 0.25, 0.38), (0.86, 0.74, 0.5), 14)
    paper = pictures.wallpaper(96, [0.8, 0.82, 0.74], [0.7, 0.74, 0.63])
    m = dict(floor=matte(glb, "floor", textures=boards), runner=printed(glb, "runner", runner),
             paper=printed(glb, "wallpaper", paper))
    for name, color in dict(
            ceiling=(0.85, 0.83, 0.8), white=(0.84, 0.83, 0.79), plain=(0.8, 0.76, 0.68), cool=(0.7, 0.76, 0.8),
            wood=(0.36, 0.21, 0.11), oak=(0.5, 0.33, 0.18), brass=(0.62, 0.47, 0.2), china=(0.88, 0.87, 0.83),
            clay=(0.66, 0.3, 0.16), blue=(0.14, 0.24, 0.45), green=(0.2, 0.4, 0.28), red=(0.55, 0.12, 0.1),
            black=(0.06, 0.06, 0.06), camel=(0.55, 0.4, 0.24), earth=(0.1, 0.07, 0.05),
            pages=(0.84, 0.78, 0.65)).items():
        m[name] = matte(glb, name, color)
    m["leaves"] = matte(glb, "leaves", (0.16, 0.36, 0.12), doubleSided=True)
    return m


def house(glb, m):
    """The hallway, a niche, three side rooms and what lies behind the corner."""
    holes = lambda side: [(*z, 0, DOOR) for z in side.values()]
    hall = arch.room(-HALF, HALF, FAR, NEAR, HIGH, THICK, left=holes(LEFT), right=holes(RIGHT))
    place(glb, "hall", hall, dict.fromkeys(hall, m["paper"]))
    out = HALF + THICK
    for name, wall, (x0, x1, z0, z1), missing in (
            ("niche", "plain", (-out - 0.45, -out, *LEFT["niche"]), "right"),
            ("corner", "plain", (-out - 1.9, -out, *LEFT["corner"]), "right"),
            ("ajar", "cool", (-out - 2.4, -out, -9.3, -6.6), "right"),
            ("near", "plain", (out, out + 1.9, -0.9, 1.5), "left"),
            ("open", "plain", (out, out + 2.3, -8.0, -5.3), "left"),
            ("last", "cool", (out, out + 1.8, -11.6, -9.2), "left")):
        # Where a room is as wide as its opening, its side walls reach into the hallway's wall.
        walls = arch.room(x0, x1, z0, z1, HIGH, 0.1, **{missing: None})
        place(glb, f"{name} room", walls, dict.fromkeys(walls, m[wall]))
    glb.add("floor", shapes.box((-4, -0.1, FAR - 0.1), (4, 0, NEAR + 0.1), 1.6), m["floor"])
    glb.add("ceiling", shapes.box((-4, HIGH, FAR - 0.1), (4, HIGH + 0.1, NEAR + 0.1)), m["ceiling"])

    length, casing = NEAR - FAR, 0.09
    trims = (("left", [(NEAR - b - casing, NEAR - a + casing) for a, b in LEFT.values()], (-HALF, 0, NEAR), 90),
             ("right", [(a - FAR - casing, b - FAR + casing) for a, b in RIGHT.values()], (HALF, 0, FAR), -90))
    for name, gaps, at, turn in trims:
        glb.add(f"{name} panelling", arch.wainscot(length, openings=gaps), m["white"], at, turn)
    glb.add("end panelling", arch.wainscot(2 * HALF), m["white"], (-HALF, 0, FAR))
    cornice = shapes.flat(*(shapes.box((a, HIGH - 0.09, FAR), (a + 0.05, HIGH, NEAR)) for a in (-HALF, HALF - 0.05)))
    glb.add("cornice", cornice, m["white"])


def doors(glb, m):
    leaf, frame = arch.door_leaf(), arch.door_frame(0.9, DOOR, THICK)
    wide = arch.door_frame(1.4, DOOR, THICK)
    wear = dict(door=m["white"], metal=m["brass"])
    for name, (low, high) in LEFT.items():
        place(glb, f"{name} frame", frame if high - low < 1 else wide, dict(frame=m["white"]), (-HALF, 0, high), 90)
    for name, (low, high) in RIGHT.items():
        place(glb, f"{name} frame", frame, dict(frame=m["white"]), (HALF, 0, low), -90)
    # A leaf's own +x points along -z on the left, +z on the right.
    for name, at, turn in (
            ("left closed", (-HALF - 0.05, 0.01, LEFT["closed"][1] - 0.02), 90),
            ("right closed", (HALF + 0.05, 0.01, RIGHT["closed"][0] + 0.02), -90),
            ("ajar", (-HALF - THICK + 0.02, 0.01, LEFT["ajar"][0] + 0.02), -90 - 38),
            ("open", (HALF + THICK - 0.02, 0.01, RIGHT["open"][1] - 0.02), 90 - 78),
            ("last", (HALF + THICK - 0.02, 0.01, RIGHT["last"][0] + 0.02), -90 + 40)):
        place(glb, f"{name} door", leaf, wear, at, turn)


def lamps(glb, m):
    """One in each side room and in the niche, where the camera cannot look; all but one shine at a ceiling."""
    warm, cool = ((1.0, 0.84, 0.62), (0.7, 0.86, 1.0))
    out, lamp = HALF + THICK, lighting.uplighter(1.7)
    for name, strength, color, at in (
            ("corner", 8000, warm, (-out - 1.5, 0, -11.45)), ("ajar", 8000, cool, (-out - 2.0, 0, -6.95)),
            ("near", 4000, warm, (out + 1.5, 0, -0.4)), ("open", 10000, warm, (out + 1.9, 0, -5.65)),
            ("last", 6000, cool, (out + 1.3, 0, -9.5))):
        bulb = glowing(glb, f"{name} bulb", strength, color=color)
        place(glb, f"{name} lamp", lamp, dict(foot=m["brass"], bowl=m["brass"], bulb=bulb), at)
    bulb = glowing(glb, "niche bulb", 8000, color=warm)
    place(glb, "niche lamp", lighting.sconce(), dict(shade=m["china"], metal=m["brass"], bulb=bulb),
          (-out - 0.1, 1.75, LEFT["niche"][1]), 180)
    off = lighting.pendant(0.45, 0.17, 0.17)
    for i, z in enumerate((-2.6, -6.6, -10.4)):
        place(glb, f"lamp that is off {i + 1}", off, dict(
            metal=m["brass"], shade=m["camel"], lining=m["china"], bulb=m["china"]),
              (0, HIGH, z))


def furnishings(glb, m):
    rng = np.random.default_rng(12)
    for i, (low, high, turn) in enumerate(((-4.55, -0.55, 1.2), (-10.3, -6.2, -0.8))):
        rug = household.rug(0.94, high - low, 0.01)
        glb.add(f"runner {i + 1}", rug, m["runner"], (0.03, 0, (low + high) / 2), turn)
    covers = household.covers(m, "red", "blue", "green", "oak", "black")
    wood = dict(wood=m["wood"], top=m["oak"], seat=m["red"], body=m["oak"], fronts=m["oak"], metal=m["brass"])

    # Left: coats, shoes and umbrellas, a radiator; in the niche a telephone table.
    for i, (z, color) in enumerate(((-2.3, "camel"), (-2.62, "blue"), (-2.98, "black"))):
        for part, m_ in zip(("coat", "sleeves"), household.coat(rng, rng.uniform(0.85, 1.05))):
            glb.add(f"{part} {i + 1}", m_, m[color], (-HALF + 0.015, 1.66, z), 90)
    rail = shapes.bars((-0.55, 0.55, 1.62, 1.72, 0, 0.022), *((x - 0.008, x + 0.008, 1.66, 1.68, 0.02, 0.09)
                                                              for x in (-0.45, -0.35, -0.02, 0.32, 0.48)))
    glb.add("coat rail", rail, m["wood"], (-HALF, 0, -2.64), 90)
    shoe = household.shoe()
    for i, (x, z, turn) in enumerate(((-0.72, -2.25, 80), (-0.7, -2.36, 95), (-0.66, -2.8, 70), (-0.68, -2.93, 110))):
        glb.add(f"shoe {i + 1}", shoe, m["black" if i < 2 else "wood"], (x, 0, z), turn)
    glb.add("umbrella stand", tableware.vase([(0.1, 0), (0.11, 0.2), (0.12, 0.45)]), m["clay"], (-0.72, 0, -5.1))
    for i, (dx, dz, lean, color) in enumerate(((0.03, 0.02, 6, "black"), (-0.04, -0.03, -7, "red"))):
        for part, m_ in household.umbrella().items():
            glb.add(f"umbrella {i + 1} {part}", shapes.turned(m_, lean, (1, 0, 0.6)),
                    m[color if part == "cloth" else "wood"], (-0.72 + dx, 0.02, -5.1 + dz), 70 * i)
    place(glb, "radiator", household.radiator(1.0), dict(metal=m["china"]), (-HALF + 0.02, 0, -6.1), 90)
    place(glb, "niche table", furniture.table(0.35, 0.9, 0.72, 0.04), wood, (-HALF - 0.36, 0, -4.1))
    glb.add("niche vase", tableware.vase([(0.05, 0), (0.11, 0.1), (0.1, 0.19), (0.05, 0.26), (0.07, 0.32)]), m["blue"],
            (-HALF - 0.34, 0.72, -4.32))

    # Right: a console with what people put down there, a chair, a chest; a plant and a bookcase at the end.
    place(glb, "console", furniture.cabinet(1.05, 0.8, 0.32, 3, (1,), legs=0.55), wood, (HALF - 0.02, 0, -2.1), -90)
    glb.add("bowl", tableware.bowl(0.13, 0.07), m["green"], (HALF - 0.2, 0.825, -1.78))
    glb.add("vase", tableware.vase([(0.045, 0), (0.09, 0.1), (0.05, 0.22), (0.03, 0.3), (0.045, 0.35)]), m["clay"],
            (HALF - 0.19, 0.825, -2.42))
    place(glb, "post", household.book_pile(3, rng, 5), covers, (HALF - 0.2, 0.825, -2.1), 40)
    place(glb, "chair", furniture.chair(), wood, (HALF - 0.36, 0, -4.75), -82)
    place(glb, "plant", nature.plant(rng, 36, 0.5, (0.16, 0.32)), dict(
        pot=m["clay"], earth=m["earth"], leaves=m["leaves"]), (0.6, 0, -12.15))
    shelf, levels = furniture.shelf(0.8, 1.1, 0.28, 3)
    place(glb, "bookcase", shelf, wood, (-0.35, 0, FAR + 0.03))
    for i, level in enumerate(levels):
        place(glb, f"books {i + 1}", household.books(0.75, 0.3, 0.25, rng, 5), covers, (-0.72, level, FAR + 0.04))

    # What can be seen of the rooms.
    out = HALF + THICK
    place(glb, "chest", furniture.cabinet(1.0, 0.9, 0.42, 2, (1, 1, 1)), wood, (out + 1.3, 0, -8.0))
    place(glb, "stool", furniture.chair(), wood, (-out - 1.2, 0, -8.7), 30)
    place(glb, "hidden chest", furniture.cabinet(0.9, 0.8, 0.4, 2, (1, 1)), wood, (out + 1.0, 0, -0.9))
    place(glb, "far chest", furniture.cabinet(0.9, 0.8, 0.4, 2, (1, 1)), wood, (out + 1.1, 0, -11.6))


def hang(glb, m):
    right, left = (HALF, -90), (-HALF, 90)
    colours = ((0.75, 0.2, 0.12), (0.15, 0.3, 0.5), (0.9, 0.65, 0.2), (0.1, 0.1, 0.1))
    prints = (("hills", pictures.landscape(160, 112, 4), 0.66, 0.48, "brass", right, -2.1, 1.6),
              ("twig", pictures.botanical(96, 128, 3), 0.36, 0.46, "wood", right, -4.6, 1.62),
              ("fern", pictures.botanical(96, 128, 8), 0.36, 0.46, "wood", right, -5.05, 1.6),
              ("leaves", pictures.botanical(96, 128, 11), 0.36, 0.46, "wood", right, -5.5, 1.62),
              ("discs", pictures.abstract(96, 128, 3, colours), 0.5, 0.66, "black", left, -0.4, 1.62),
              ("sea", pictures.landscape(160, 112, 7, ((0.3, 0.4, 0.6), (0.9, 0.75, 0.6)), (0.1, 0.2, 0.3)), 0.7, 0.5,
               "black", left, -6.1, 1.6),
              ("bars", pictures.abstract(96, 128, 8, colours), 0.44, 0.58, "black", right, -8.4, 1.62))
    for name, image, width, height, frame, (x, turn), z, y in prints:
        wear = dict(frame=m[frame], mat=m["china"], print=printed(glb, name, image))
        place(glb, name, household.picture(width, height, 0.025, 0.05), wear, (x, y, z), turn)
    end = pictures.landscape(160, 112, 13, ((0.5, 0.6, 0.8), (0.97, 0.8, 0.6)), (0.3, 0.25, 0.12))
    place(glb, "end", household.picture(0.9, 0.66, 0.04, 0.06), dict(
        frame=m["brass"], mat=m["china"], print=printed(glb, "end", end)), (0.05, 1.75, FAR))


def main():
    glb = scene.begin("hallway", (640, 360))
    m = materials(glb)
    for part in (house, doors, lamps, furnishings, hang):
        part(glb, m)
    glb.camera("along", (0.22, 1.5, 0.95), (-0.1, 1.14, -6), 44)
    scene.save(glb)


if __name__ == "__main__":
    main()
