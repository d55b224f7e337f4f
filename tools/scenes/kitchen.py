#!/usr/bin/env python3
"""Makes scenes/kitchen.glb: a kitchen in the evening with steel, copper and glazed tiles.

Its light comes from deep within fixtures: strips behind the lips of the wall cupboards, spots in the hood, domes over
the table. Brushed metals (roughness 0.15 to 0.35) spread glossy glimpses of them, and lobes must be matched with
where the light is.

    python3 tools/scenes/kitchen.py [OUT.glb]
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
from shapes import bars

LEFT, RIGHT, BACK, FRONT, HIGH = -2.3, 2.1, 0.0, 4.2, 2.55
TOP, DEPTH, OVER = 0.9, 0.62, 1.45  # the worktop's height and depth, where the wall cupboards begin
WINDOW = (1.35, 2.45, 1.12, 2.02)  # in the left wall: z from, z to, y from, y to


def materials(glb):
    wall_tiles = pictures.tiles(256, 8, ((0.86, 0.88, 0.84), (0.82, 0.86, 0.83), (0.88, 0.88, 0.85),
                                         (0.62, 0.74, 0.74)),
                                (0.6, 0.58, 0.55), 3, 0.06)
    floor = pictures.checkers(256, 4, (0.82, 0.79, 0.72), (0.3, 0.33, 0.34), (0.45, 0.43, 0.4))
    butcher = pictures.boards(256, 10, (0.78, 0.58, 0.38), (0.62, 0.42, 0.25), 4)
    grain = pictures.few(pictures.wood(192, 96, [0.62, 0.44, 0.28], [0.46, 0.3, 0.17], 6))
    m = dict(tiles=glb.material("tiles", roughness=0.2, textures=glb.texture("tiles", wall_tiles)),
             floor=printed(glb, "floor", floor),
             worktop=printed(glb, "worktop", butcher),
             grain=matte(glb, "table top", textures=glb.texture("grain", grain)))
    for name, color in dict(
            wall=(0.8, 0.76, 0.68), ceiling=(0.86, 0.85, 0.82), white=(0.84, 0.83, 0.8), paint=(0.5, 0.6, 0.58),
            oak=(0.5, 0.34, 0.2), seat=(0.72, 0.62, 0.45), black=(0.04, 0.04, 0.045), red=(0.62, 0.09, 0.06),
            yellow=(0.85, 0.64, 0.1), green=(0.3, 0.48, 0.14), cream=(0.86, 0.82, 0.72), bread=(0.62, 0.38, 0.17),
            clay=(0.66, 0.32, 0.19), blue=(0.14, 0.26, 0.46), earth=(0.1, 0.07, 0.05),
            pages=(0.84, 0.79, 0.68)).items():
        m[name] = matte(glb, name, color)
    for name, color in dict(leaves=(0.18, 0.38, 0.14), towel=(0.75, 0.3, 0.22)).items():
        m[name] = matte(glb, name, color, doubleSided=True)
    for name, color, roughness in (("steel", (0.65, 0.64, 0.62), 0.22), ("brushed", (0.58, 0.57, 0.56), 0.35),
                                   ("chrome", (0.72, 0.72, 0.73), 0.15), ("copper", (0.92, 0.6, 0.46), 0.2),
                                   ("iron", (0.25, 0.25, 0.26), 0.35)):
        m[name] = glb.material(name, color, metallic=1.0, roughness=roughness)
    m["enamel"] = glb.material("enamel", (0.02, 0.02, 0.025), roughness=0.15)
    m["glaze"] = glb.material("glaze", (0.85, 0.83, 0.78), roughness=0.2)
    return m


def house(glb, m):
    walls = arch.room(LEFT, RIGHT, BACK, FRONT, HIGH, 0.18, left=[WINDOW])
    place(glb, "wall", walls, dict.fromkeys(walls, m["wall"]))
    glb.add("floor", shapes.box((LEFT - 0.1, -0.1, BACK - 0.1), (RIGHT + 0.1, 0, FRONT + 0.1), 1.4), m["floor"])
    glb.add("ceiling", shapes.box((LEFT - 0.1, HIGH, BACK - 0.1), (RIGHT + 0.1, HIGH + 0.1, FRONT + 0.1)), m["ceiling"])
    glb.add("tiles behind", shapes.box((LEFT, TOP, -0.01), (1.3, OVER + 0.02, 0.01), 1.2), m["tiles"])
    glb.add("tiles behind the hood", shapes.box((-0.46, OVER + 0.02, -0.01), (0.46, 2.1, 0.01), 1.2), m["tiles"])
    glb.add("tiles left", shapes.box((LEFT - 0.01, TOP, 0.01), (LEFT + 0.01, WINDOW[2] - 0.04, 3.0), 1.2), m["tiles"])
    z0, z1, low, high = WINDOW
    frame = arch.window_frame(z1 - z0, high - low, 0.12)
    place(glb, "window", frame, dict(frame=m["white"]), (LEFT, low, z1), 90)
    night = glowing(glb, "night", 0.8, color=(0.2, 0.36, 0.8))
    glb.add("night", shapes.quad((LEFT - 0.12, low - 0.02, z1 + 0.02), (0, 0, z0 - z1 - 0.04),
                                 (0, high - low + 0.04, 0)),
            night)
    glb.add("window sill", bars((LEFT - 0.1, LEFT + 0.06, low - 0.04, low + 0.002, z0 - 0.06, z1 + 0.06)), m["white"])


def cupboards(glb, m):
    """An L of base cupboards, wall cupboards beside the hood, a refrigerator."""
    wear = dict(body=m["paint"], fronts=m["paint"], top=m["paint"], metal=m["steel"])

    def run(name, piece, at, turn=0.0, **more):
        piece.pop("top")
        place(glb, name, piece, {**wear, **more}, at, turn)
    base = lambda width, columns, rows, high=TOP - 0.04: furniture.cabinet(width, high, DEPTH - 0.04, columns, rows,
                                                                           0.1, 0.16)
    run("left doors", base(1.32, 2, (1, 3.2)), (-0.96, 0, 0))
    run("right drawers", base(0.5, 1, (1, 1.6, 1.6)), (0.55, 0, 0))
    run("right doors", base(0.5, 1, (1, 3.2)), (1.05, 0, 0))
    run("corner", base(0.68, 1, (1,)), (LEFT, 0, 0.96), 90)
    run("under the sink", base(0.8, 2, (1,), 0.64), (LEFT, 0, 1.7), 90)
    run("side doors", base(0.9, 2, (1, 3.2)), (LEFT, 0, 2.55), 90)
    plinth = bars((LEFT, -0.3, 0, 0.1, 0.02, 0.53), (0.3, 1.3, 0, 0.1, 0.02, 0.53),
                  (LEFT + 0.02, LEFT + 0.53, 0, 0.1, 0.53, 3.0))
    glb.add("plinth", plinth, m["black"])
    glb.add("corner post", bars((LEFT, -1.62, 0.1, TOP - 0.04, 0.0, 0.575)), m["paint"])
    low, d = TOP - 0.04, DEPTH
    for i, (a, b) in enumerate((((LEFT, -0.302), (0.0, d)), ((0.302, 1.31), (0.0, d)), ((LEFT, LEFT + d), (d, 1.3)),
                                ((LEFT, LEFT + d), (2.1, 3.02)), ((LEFT, LEFT + 0.12), (1.3, 2.1)))):
        glb.add(f"worktop {i + 1}", shapes.box((a[0], low, b[0]), (a[1], TOP, b[1]), 0.9), m["worktop"])

    for i, (width, columns, x) in enumerate(((0.86, 2, -0.9), (0.84, 2, 0.89), (0.92, 2, -1.81))):
        run(f"wall cupboard {i + 1}", furniture.cabinet(width, 0.72, 0.33, columns, (1,), 0, 0.16), (x, OVER, 0))
    cold = [shapes.rounded((1.36, 0.04, 0.05), (2.02, 0.68, 0.7), 0.02, 2),
            shapes.rounded((1.36, 0.69, 0.05), (2.02, 1.85, 0.7), 0.02, 2)]
    glb.add("refrigerator", shapes.joined(*cold), m["brushed"])
    grip = shapes.joined(shapes.moved(furniture.bar_handle(0.5), (1.41, 1.0, 0.7)),
                         shapes.moved(furniture.bar_handle(0.24), (1.41, 0.5, 0.7)))
    glb.add("refrigerator grips", shapes.flat(grip), m["chrome"])


def stove(glb, m):
    """A range of steel with an oven, its hood, and the pots on it."""
    body = bars((-0.298, 0.298, 0.08, TOP - 0.005, 0.02, 0.6), (-0.298, 0.298, 0.0, 0.08, 0.05, 0.55),
                (-0.29, 0.29, 0.16, 0.7, 0.6, 0.62), (-0.298, 0.298, TOP - 0.005, TOP + 0.07, 0.012, 0.03))
    glb.add("range", body, m["brushed"])
    glb.add("oven window", bars((-0.2, 0.2, 0.3, 0.58, 0.6, 0.623)), m["enamel"])
    glb.add("hob", bars((-0.295, 0.295, TOP - 0.005, TOP + 0.004, 0.03, 0.598)), m["enamel"])
    glb.add("oven grip", shapes.flat(shapes.moved(furniture.bar_handle(0.46, upright=False), (0, 0.65, 0.62))),
            m["chrome"])
    turn = shapes.turned(shapes.creased([(0.02, 0), (0.018, 0.022), (0, 0.022)], 16), 90)
    ring = shapes.creased([(0.1, 0), (0.1, 0.008), (0.08, 0.008), (0.08, 0)], 32)
    for i in range(5):
        glb.add(f"knob {i + 1}", turn, m["chrome"], (-0.22 + 0.11 * i, 0.79, 0.6))
    for i, (x, z) in enumerate(((-0.15, 0.18), (0.15, 0.18), (-0.15, 0.44), (0.15, 0.44))):
        glb.add(f"burner {i + 1}", ring, m["iron"], (x, TOP + 0.004, z))
    at = lambda x, z: (x, TOP + 0.012, z)
    glb.add("stock pot", tableware.pot(0.125, 0.19), m["steel"], at(-0.14, 0.19), 20)
    glb.add("saucepan", tableware.pot(0.09, 0.1, True), m["copper"], at(0.14, 0.42), -25)
    glb.add("kettle", tableware.teapot(1.35), m["chrome"], at(-0.13, 0.43), 215)

    # Its hood: a lip, a truncated pyramid, a chimney; below it two spots in sunk rings.
    w, deep, low, top = 0.45, 0.5, 1.62, 1.95
    corners = [(-w, low + 0.06, deep), (w, low + 0.06, deep), (w, low + 0.06, 0), (-w, low + 0.06, 0),
               (-0.15, top, 0.28), (0.15, top, 0.28), (0.15, top, 0), (-0.15, top, 0)]
    slopes = shapes.mesh(corners, [(0, 1, 5), (0, 5, 4), (1, 2, 6), (1, 6, 5), (3, 0, 4), (3, 4, 7)])
    glb.add("hood", shapes.flat(slopes, bars((-w, w, low, low + 0.06, 0, deep), (-0.15, 0.15, top, HIGH, 0, 0.28))),
            m["steel"])
    spot = glowing(glb, "spot", 700, color=(1.0, 0.85, 0.66))
    for i, x in enumerate((-0.24, 0.24)):
        collar = shapes.creased([(0.035, 0.0), (0.042, -0.035), (0.04, -0.035), (0.033, 0.0)][::-1], 20)
        glb.add(f"spot ring {i + 1}", collar, m["chrome"], (x, low, 0.3))
        glb.add(f"spot {i + 1}", shapes.disc(0.033, -0.003, 12, up=False), spot, (x, low, 0.3))


def lamps(glb, m):
    """Strips below the wall cupboards behind lips, and domes over the table."""
    low_strip, high_strip = (glowing(glb, f"{name} strip", strength, color=(1.0, 0.84, 0.64)) for name, strength in (
        ("lower", 70), ("upper", 190)))
    for i, (low, high) in enumerate(((-1.28, -0.52), (0.52, 1.26), (-2.1, -1.4))):
        y = OVER - 0.001
        lips = bars((low, high, y - 0.035, y, 0.2, 0.212), (low, high, y - 0.035, y, 0.15, 0.162),
                    (low - 0.01, low, y - 0.035, y, 0.15, 0.212), (high, high + 0.01, y - 0.035, y, 0.15, 0.212))
        glb.add(f"strip lips {i + 1}", lips, m["brushed"])
        glb.add(f"strip {i + 1}", shapes.quad((low, y - 0.002, 0.165), (high - low, 0, 0), (0, 0, 0.032)), low_strip)
        if i < 2:  # and on top of two of them, towards the ceiling, behind a cornice
            glb.add(f"cornice {i + 1}", bars((low - 0.1, high + 0.09, OVER + 0.72, OVER + 0.76, 0.33, 0.35)),
                    m["paint"])
            glb.add(f"upper strip {i + 1}", shapes.quad((low, OVER + 0.73, 0.3), (high - low, 0, 0), (0, 0, -0.04)),
                    high_strip)
    bulb, lamp = glowing(glb, "dome bulb", 260, color=(1.0, 0.74, 0.45)), lighting.dome(1.0, 0.19, 0.17)
    wear = dict(rod=m["black"], cap=m["chrome"], shade=m["copper"], inside=m["white"], bulb=bulb)
    for i, x in enumerate((-0.42, 0.38)):
        place(glb, f"dome {i + 1}", lamp, wear, (x, HIGH, 2.55))


def sink(glb, m):
    x, (a, b) = LEFT + 0.12, (1.302, 2.098)
    low, high, out, wall = 0.65, TOP - 0.004, LEFT + DEPTH + 0.015, 0.016
    glb.add("sink", bars((x, out, low, low + 0.03, a, b), (x, x + wall, low + 0.03, high, a, b),
                         (out - wall, out, low + 0.03, high, a, b),
                         (x + wall, out - wall, low + 0.03, high, a, a + wall),
                         (x + wall, out - wall, low + 0.03, high, b - wall, b)), m["steel"])
    glb.add("tap", tableware.tap(), m["chrome"], (LEFT + 0.06, TOP, 1.7), 90)
    drain = shapes.creased([(0.04, 0.0), (0.036, 0.004), (0, 0.002)], 20)
    glb.add("drain", drain, m["chrome"], (LEFT + 0.36, low + 0.03, 1.7))
    fold = lambda s, t: (0.3 * (s - 0.5), -0.42 * t, 0.03 + 0.012 * np.sin(14 * s) * (0.3 + t))
    glb.add("towel", forms.surface(fold, 20, 8), m["towel"], (0.02, 0.66, 0.632))
    for i, (z, size, color) in enumerate(((2.28, 0.034, "green"), (2.38, 0.03, "clay"))):
        glb.add(f"soap {i + 1}", tableware.bottle(size, 0.2), m[color], (LEFT + 0.14, TOP, z))
    plate = tableware.plate(0.12)
    for i in range(5):  # in a rack beside the sink, on edge
        stood = shapes.turned(plate, 78, (0, 0, 1))
        glb.add(f"drying plate {i + 1}", stood, m["glaze"], (LEFT + 0.33, TOP + 0.125, 2.34 + 0.07 * i), -90)
    rack = [forms.pipe([(LEFT + 0.2, TOP + y, z), (LEFT + 0.46, TOP + y, z)], 0.004, 6) for y in (0.01, 0.08)
            for z in np.linspace(2.27, 2.69, 7)]
    ends = [forms.pipe([(x, TOP + y, 2.25), (x, TOP + y, 2.71)], 0.005, 6) for x in (LEFT + 0.2, LEFT + 0.46)
            for y in (0.01, 0.08)]
    glb.add("rack", shapes.flat(*rack, *ends), m["chrome"])


def things(glb, m):
    rng = np.random.default_rng(9)
    rail = forms.pipe([(-1.3, 1.33, 0.05), (-0.48, 1.33, 0.05)], 0.008, 10)
    posts = [forms.pipe([(x, 1.33, 0.005), (x, 1.33, 0.05)], 0.006, 8) for x in (-1.25, -0.53)]
    glb.add("rail", shapes.flat(rail, *posts), m["chrome"])
    for i, (x, radius, metal) in enumerate(((-1.17, 0.085, "copper"), (-0.96, 0.095, "iron"))):
        glb.add(f"pan {i + 1}", tableware.pan(radius), m[metal], (x, 1.33, 0.03))
    spoon = shapes.sphere(0.034, 2)
    spoon = shapes.mesh(spoon["positions"] * (1, 1.3, 0.35), spoon["triangles"], spoon["normals"])
    for i, x in enumerate((-0.8, -0.7, -0.6)):
        handle = forms.pipe([(x, 1.345, 0.06), (x, 1.04, 0.055)], 0.005, 8)
        glb.add(f"ladle {i + 1}", shapes.flat(handle, shapes.moved(spoon, (x, 1.02, 0.05))), m["steel"])
    jar = tableware.vase([(0.05, 0), (0.052, 0.06), (0.052, 0.13), (0.045, 0.15)], 28)
    lid = shapes.creased([(0.047, 0.0), (0.047, 0.02), (0.012, 0.024), (0.012, 0.036), (0, 0.036)], 24)
    for i, (x, z, scale, color) in enumerate(((0.62, 0.17, 1.25, "cream"), (0.78, 0.16, 1.05, "cream"),
                                              (0.91, 0.17, 0.88, "cream"), (-1.95, 0.2, 1.2, "blue"))):
        glb.add(f"jar {i + 1}", jar, m[color], (x, TOP, z), 0, scale)
        glb.add(f"lid {i + 1}", lid, m["oak"], (x, TOP + 0.15 * scale, z), 0, scale)
    toaster = shapes.rounded((-0.14, 0.01, -0.09), (0.14, 0.19, 0.09), 0.035, 3)
    glb.add("toaster", toaster, m["chrome"], (1.1, TOP, 0.3), -12)
    glb.add("slots", bars((-0.1, 0.1, 0.185, 0.1925, -0.045, -0.015), (-0.1, 0.1, 0.185, 0.1925, 0.015, 0.045)),
            m["black"],
            (1.1, TOP, 0.3), -12)
    for i, (x, z, size, color) in enumerate(((-1.5, 0.16, 0.3, "green"), (-1.41, 0.13, 0.26, "clay"),
                                             (-1.6, 0.13, 0.33, "black"))):
        glb.add(f"bottle {i + 1}", tableware.bottle(0.036, size), m[color], (x, TOP, z))
    glb.add("chopping board", shapes.rounded((-0.2, 0, -0.14), (0.2, 0.025, 0.14), 0.01), m["oak"], (-0.75, TOP, 0.36),
            12)
    for i, (x, z, color) in enumerate(((-0.8, 0.38, "red"), (-0.7, 0.34, "red"), (-0.62, 0.41, "green"))):
        glb.add(f"tomato {i + 1}", shapes.sphere(0.034, 2), m[color], (x, TOP + 0.058, z))
    place(glb, "herbs", nature.plant(rng, 30, 0.15, (0.055, 0.1)), dict(
        pot=m["clay"], earth=m["earth"], leaves=m["leaves"]), (LEFT - 0.02, WINDOW[2] + 0.002, 2.2))
    glb.add("sill jug", tableware.vase([(0.04, 0), (0.06, 0.05), (0.035, 0.13), (0.045, 0.17)]), m["blue"],
            (LEFT - 0.01, WINDOW[2] + 0.002, 1.55))
    covers = household.covers(m, "red", "blue", "cream", "green", "clay")
    place(glb, "cookery books", household.books(0.36, 0.27, 0.22, rng, 5, 0.9), covers, (LEFT + 0.05, TOP, 3.0), 90)


def table(glb, m):
    """A table in the middle, set about with what a meal began with."""
    at, top = (0.0, 0, 2.55), 0.75
    place(glb, "table", furniture.table(1.7, 0.85, top), dict(wood=m["white"], top=m["grain"]), at)
    chair = furniture.chair()
    for i, (x, z, turn) in enumerate(((-0.4, 1.98, 6), (0.42, 1.86, -14), (-1.12, 2.6, 82))):
        place(glb, f"chair {i + 1}", chair, dict(wood=m["oak"], seat=m["seat"]), (x, 0, z), turn)
    glb.add("fruit bowl", tableware.bowl(0.16, 0.09), m["copper"], (-0.25, top, 2.5))
    for i, (dx, dy, dz, color) in enumerate(((-0.06, 0.05, 0.02, "red"), (0.05, 0.05, 0.05, "yellow"),
                                             (0.03, 0.05, -0.06, "green"), (0.0, 0.108, 0.01, "yellow"))):
        glb.add(f"fruit {i + 1}", shapes.sphere(0.04, 3), m[color], (-0.25 + dx, top + dy, 2.5 + dz))
    glb.add("bread board", shapes.rounded((-0.22, 0, -0.14), (0.22, 0.022, 0.14), 0.01), m["oak"], (0.3, top, 2.62),
            -16)
    loaf = shapes.sphere(1.0, 3)
    loaf = shapes.mesh(loaf["positions"] * (0.15, 0.06, 0.075), loaf["triangles"], loaf["normals"])
    glb.add("bread", loaf, m["bread"], (0.26, top + 0.075, 2.6), -30)
    blade = shapes.flat(shapes.prism([(0, 0.012), (0.16, 0.014), (0.2, 0), (0.0, -0.014)], 0, 0.002))
    glb.add("knife", blade, m["chrome"], (0.36, top + 0.024, 2.74), 15)
    glb.add("knife handle", shapes.rounded((-0.11, -0.005, -0.012), (0.003, 0.012, 0.012), 0.005), m["black"],
            (0.36, top + 0.027, 2.74), 15)
    mug, dish = tableware.mug(), tableware.plate(0.11)
    for i, (x, z, turn) in enumerate(((-0.58, 2.72, 60), (0.02, 2.36, 150))):
        glb.add(f"mug {i + 1}", mug, m["glaze"], (x, top, z), turn)
    glb.add("dish", dish, m["glaze"], (0.62, top, 2.4))
    glb.add("oil", tableware.bottle(0.034, 0.27), m["green"], (0.6, top, 2.75))
    glb.add("milk jug", tableware.vase([(0.04, 0), (0.052, 0.04), (0.036, 0.11), (0.045, 0.15)]), m["steel"],
            (0.05, top, 2.72))


def main():
    glb = scene.begin("kitchen", (640, 360))
    m = materials(glb)
    for part in (house, cupboards, stove, lamps, sink, things, table):
        part(glb, m)
    glb.camera("room", (1.3, 1.5, 3.9), (-0.42, 1.04, 0.6), 44)
    scene.save(glb)


if __name__ == "__main__":
    main()
