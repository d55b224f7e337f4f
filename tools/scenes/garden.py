#!/usr/bin/env python3
"""Makes scenes/garden.glb: a walled corner of a garden under trees. Sun and sky reach the ground through masked leaves,
so that visibility changes from one point to the next: what connects well at one place is no guide for its neighbour,
and much light has passed from leaf to leaf. Wholly Lambert.

    python3 tools/scenes/garden.py [OUT.glb]
"""

import numpy as np

import architecture as arch
import nature
import scene
import shapes
from forms import sheet, swept
from looks import lit, matte, printed
from pictures import blocks, cloudy, lawn, planks, sky, spray

SKY_RADIUS = 16.0
SUN = np.array([-0.6, 0.74, 0.24])  # towards it
POND = np.array([1.55, -0.9])  # x, z of its middle


def leafy(glb, name, picture, tint):
    return printed(glb, name, picture, tint, doubleSided=True, alphaMode="MASK", alphaCutoff=0.5)


def looks(glb):
    narrow, broad = spray(128), spray(128, 15, 5)
    stone = blocks([0.62, 0.56, 0.48], [0.42, 0.37, 0.31], [0.26, 0.24, 0.21], 6, 3, seed=3, gap=0.014)
    return dict(
        lime=leafy(glb, "lime leaves", narrow, (0.85, 1.0, 0.8)),
        birch=leafy(glb, "birch leaves", narrow, (1.0, 1.0, 0.55)),
        hedge=leafy(glb, "hedge leaves", narrow, (0.6, 0.75, 0.55)), ivy=leafy(glb, "ivy", broad, (0.65, 0.85, 0.6)),
        bush=leafy(glb, "bush leaves", broad, (0.95, 1.0, 0.75)),
        core=matte(glb, "inside of the hedge", (0.035, 0.045, 0.02)),
        bark=printed(glb, "bark", cloudy([0.3, 0.23, 0.17], [0.13, 0.1, 0.075], 10, 64, seed=5)),
        pale_bark=printed(glb, "birch bark", cloudy([0.75, 0.72, 0.67], [0.2, 0.18, 0.16], 6, 64, seed=9)),
        stone=printed(glb, "garden wall", stone), cap=matte(glb, "coping", (0.5, 0.46, 0.4)),
        slab=printed(glb, "path slabs", cloudy([0.62, 0.58, 0.52], [0.46, 0.43, 0.38], 10, 64, seed=2)),
        pebble=matte(glb, "pebble", (0.45, 0.43, 0.4)), mud=matte(glb, "pond bed", (0.2, 0.16, 0.11)),
        lawn=printed(glb, "lawn", lawn([0.27, 0.37, 0.13], [0.16, 0.25, 0.08])),
        blade=matte(glb, "grass", (0.2, 0.38, 0.07), doubleSided=True),
        dry=matte(glb, "reed", (0.42, 0.45, 0.16), doubleSided=True),
        teak=printed(glb, "teak", planks([0.5, 0.36, 0.22], [0.36, 0.24, 0.14], 4, 64, seed=6)),
        clay=matte(glb, "clay", (0.58, 0.27, 0.16)), zinc=matte(glb, "zinc", (0.38, 0.4, 0.41)),
        rose=matte(glb, "petals", (0.78, 0.16, 0.2), doubleSided=True),
        white=matte(glb, "white petals", (0.82, 0.8, 0.74), doubleSided=True))


def height(x, z):
    """Gentle waves, a hollow where the pond was, flat under the walls."""
    wave = 0.05 * np.sin(0.7 * x + 1.1) * np.cos(0.6 * z)
    away = np.hypot((x - POND[0]) / 1.15, (z - POND[1]) / 0.85)
    return wave - 0.38 * np.exp(-(away**4))


def on_ground(x, z, sunk=0.0):
    return (x, float(height(x, z)) - sunk, z)


def terrain(glb, look, rng):
    glb.add("lawn", nature.ground(6.0, height, 72), look["lawn"])
    r, a = np.meshgrid(np.linspace(0.002, 1, 9), np.linspace(0, 2 * np.pi, 41), indexing="ij")
    x, z = POND[0] + 1.25 * r * np.cos(a), POND[1] - 0.93 * r * np.sin(a)
    glb.add("pond bed", sheet(np.stack([x, height(x, z) + 0.012, z], 2)), look["mud"])
    far = arch.frame((5.98, 5.98), (SKY_RADIUS, SKY_RADIUS), -0.2, -0.06, 2.0)
    glb.add("field", far, look["lawn"])
    slab = shapes.moved(shapes.box((-0.3, 0, -0.21), (0.3, 0.05, 0.21), 0.6))
    for k in range(15):
        x, z = -0.75 - 0.5 * np.sin(0.42 * k), 4.3 - 0.54 * k
        glb.add("slab", slab, look["slab"], on_ground(x, z, 0.025), 14 * np.sin(2.3 * k) + 8)
    kinds = [nature.stone(rng, size) for size in ((0.34, 0.2, 0.26), (0.26, 0.17, 0.3), (0.42, 0.26, 0.32))]
    for k, a in enumerate(np.linspace(0, 2 * np.pi, 25, endpoint=False)):
        reach = rng.uniform(0.95, 1.08)
        x, z = POND + np.array([1.3, 0.98]) * reach * (np.cos(a), np.sin(a))
        glb.add("stone", kinds[k % 3], look["pebble" if k % 4 else "cap"], on_ground(x, z, 0.07), rng.uniform(0, 360),
                rng.uniform(0.75, 1.15))
    for _ in range(16):
        x, z = POND + rng.normal(size=2) * 0.33
        glb.add("pebble", kinds[0], look["pebble"], on_ground(x, z, 0.02), rng.uniform(0, 360), rng.uniform(0.2, 0.45))
    tufts = [nature.tuft(rng, 16, 0.17), nature.tuft(rng, 14, 0.24, 0.6)]
    for x, z in rng.uniform((-4.5, -4.2), (4.5, 4.6), (420, 2)):
        pond = np.hypot((x - POND[0]) / 1.5, (z - POND[1]) / 1.2) < 1
        path = abs(x + 0.75 + 0.5 * np.sin(0.42 * (4.3 - z) / 0.54)) < 0.42
        if not pond and not path:
            glb.add("tuft", tufts[rng.integers(2)], look["blade"], on_ground(x, z), round(rng.uniform(0, 360)),
                    round(rng.uniform(0.5, 1.1), 2))
    reed = nature.tuft(rng, 18, 0.8, 0.3)
    for a in (2.4, 2.75, 3.0, 5.2, 5.5):
        x, z = POND + np.array([1.5, 1.15]) * (np.cos(a), -np.sin(a))
        glb.add("reed", reed, look["dry"], on_ground(x, z), 77 * a)


def walls(glb, look, rng):
    """A wall at the back with a gateway, another to the left, ivy on both; a hedge to the right."""
    back = arch.pierced_wall(10.4, 2.1, 0.35, [(3.5, 0.0, 4.6, 2.1)], 1.4)
    glb.add("back wall", back, look["stone"], (-5.2, -0.15, -4.6))
    glb.add("left wall", arch.pierced_wall(9.0, 2.1, 0.35, [], 1.4), look["stone"], (-5.0, -0.15, 4.4), 90)
    for low, high in (((-5.25, 1.95, -4.83), (-1.66, 2.03, -4.37)), ((-0.64, 1.95, -4.83), (5.2, 2.03, -4.37)),
                      ((-5.23, 1.951, -4.36), (-4.77, 2.031, 4.4))):
        glb.add("coping", shapes.box(low, high), look["cap"])
    arch_over = arch.arch_panel(1.5, 2.75, 0.55, 2.0, 0.36, 1.4)
    glb.add("gate arch", arch_over, look["stone"], (-1.15, -0.15, -4.6))
    glb.add("gate top", shapes.box((-0.78, 2.6, -0.23), (0.78, 2.7, 0.23)), look["cap"], (-1.15, 0, -4.6))
    for s in (-1, 1):  # the arch's ends, above the wall's height
        glb.add("gate end", shapes.box((s * 0.75 - 0.01, 1.85, -0.179), (s * 0.75 + 0.01, 2.6, 0.179)), look["cap"],
                (-1.15, 0, -4.6))
    gate = [shapes.box((x - 0.05, 0.08, -0.015), (x + 0.05, 1.25 + 0.18 * np.sin(np.pi * (x + 0.05)), 0.015))
            for x in np.arange(0.06, 1.05, 0.125)]
    gate += [shapes.box((0, y, 0.015), (1.05, y + 0.09, 0.04)) for y in (0.3, 0.95)]
    glb.add("gate", shapes.joined(*gate), look["teak"], (-1.66, 0, -4.5), 62)
    ivy = nature.thicket((-1.3, 0.1, -0.06), (1.3, 2.1, 0.06), 420, rng, 0.3)
    for x, z, turn in ((3.6, -4.38, 0), (2.0, -4.42, 180), (-4.78, -2.2, 90), (-4.8, 1.2, 90)):
        glb.add("ivy", ivy, look["ivy"], (x, -0.1, z), turn)
    hedge = nature.thicket((-1.5, 0, -0.4), (1.5, 1.55, 0.4), 1300, rng, 0.24)
    core = shapes.box((-1.42, 0, -0.33), (1.42, 1.46, 0.33))
    for z in (-2.9, 0.0, 2.9):
        glb.add("hedge", hedge, look["hedge"], (4.9, -0.12, z), 90)
        glb.add("inside of the hedge", core, look["core"], (4.9, -0.12, z), 90)


def trees(glb, look):
    for i, (x, z, tall, leaf, bark, turn) in enumerate((
            (2.9, -2.9, 1.75, "lime", "bark", 0), (-3.3, -2.9, 1.9, "birch", "pale_bark", 40),
            (3.4, 2.3, 1.8, "lime", "bark", 100), (-3.5, 1.7, 2.0, "birch", "pale_bark", 150),
            (-1.9, -8.2, 2.2, "lime", "bark", 200), (3.2, -8.4, 2.4, "birch", "bark", 70))):
        rng = np.random.default_rng(40 + i)
        wood, tips = nature.branching(rng, tall, 0.13, 3, 3, 0.8)
        glb.add("tree", wood, look[bark], on_ground(x, z, 0.08), turn)
        glb.add("crown", nature.crown(tips, rng, 11, 0.3, 0.5), look[leaf], on_ground(x, z, 0.08), turn)


def furniture(glb, look, rng):
    plank = lambda low, high: shapes.box(low, high, 0.8)
    slats = [plank((-0.8, 0.42, z - 0.045), (0.8, 0.45, z + 0.045)) for z in (-0.18, -0.07, 0.04, 0.15)]
    rest = [shapes.turned(plank((-0.8, y, -0.012), (0.8, y + 0.08, 0.012)), -10, offset=(0, 0.02, -0.16))
            for y in (0.52, 0.64, 0.76)]
    legs = [plank((x - 0.035, -0.05, z - 0.035), (x + 0.035, top, z + 0.035))
            for x in (-0.74, 0.74) for z, top in ((0.17, 0.62), (-0.27, 0.92))]
    arms = [plank((x - 0.045, 0.62, -0.27), (x + 0.045, 0.655, 0.24)) for x in (-0.74, 0.74)]
    glb.add("bench", shapes.joined(*slats, *rest, *legs, *arms), look["teak"], on_ground(1.5, -3.4, 0.01), -12)
    pot = shapes.lathe([(0, 0), (0.12, 0)], [(0.12, 0), (0.18, 0.28)],
                       [(0.18, 0.28), (0.2, 0.29), (0.2, 0.35), (0.175, 0.35)],
                       [(0.175, 0.35), (0.16, 0.3), (0.0, 0.3)], segments=28)
    n = rng.normal(size=(150, 3)) + (0, 0.8, 0)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    bush = nature.cards(n * 0.26 * rng.uniform(0.6, 1.05, (150, 1)) + (0, 0.12, 0), n, np.full(150, 0.17), rng)
    petals = nature.cards(n[:60] * 0.3 + (0, 0.14, 0), n[:60], np.full(60, 0.07), rng)
    for x, z, scale, bloom in ((0.35, -3.75, 1.0, "rose"), (2.75, -3.75, 1.15, "white"), (-2.1, -4.0, 1.1, "white"),
                               (-0.2, -4.05, 0.95, "rose"), (-2.2, 1.3, 1.0, "rose")):
        at = on_ground(x, z, 0.01)
        glb.add("pot", pot, look["clay"], at, 0, scale)
        up = (at[0], at[1] + 0.3 * scale, at[2])
        glb.add("bush", bush, look["bush"], up, 60 * x, scale)
        glb.add("blossoms", petals, look[bloom], up, 60 * x, scale)
    for x, z, scale in ((-4.0, -3.6, 2.2), (-3.9, 0.2, 2.0), (3.9, -3.7, 2.1), (-4.1, 2.2, 2.4), (3.6, 0.9, 1.9)):
        glb.add("bush", bush, look["bush"], on_ground(x, z, -0.2), 50 * z, scale)
        glb.add("blossoms", petals, look["rose" if x < 0 else "white"], on_ground(x, z, -0.2), 50 * z, scale)
    can = shapes.lathe([(0, 0), (0.11, 0)], [(0.11, 0), (0.115, 0.26)],
                       [(0.115, 0.26), (0.1, 0.262), (0.095, 0.1), (0, 0.1)],
                       segments=28)
    t = np.linspace(0, np.pi, 16)
    handle = swept(np.stack([0 * t, 0.26 + 0.1 * np.sin(t), 0.105 * np.cos(t)], 1), 0.008, 8)
    spout = swept([(0.1, 0.06, 0), (0.2, 0.16, 0), (0.3, 0.3, 0)], [0.024, 0.018, 0.014], 10)
    glb.add("watering can", shapes.joined(can, handle, spout), look["zinc"], on_ground(0.15, 1.15, 0.01), 25)


def light(glb):
    dome = nature.dome(SKY_RADIUS, -0.25, 6, 24)
    glb.add("sky", dome, lit(glb, "sky", 1.7, picture=sky([0.3, 0.5, 0.92], [0.8, 0.88, 0.98], 64)))
    toward = SUN / np.linalg.norm(SUN)
    scene.sun_disc(glb, toward * (SKY_RADIUS - 1.0), -toward, 0.12, 22.0, (1.0, 0.9, 0.74))


def main():
    glb = scene.begin("garden", (640, 360))
    look, rng = looks(glb), np.random.default_rng(31)
    terrain(glb, look, rng)
    walls(glb, look, rng)
    trees(glb, look)
    furniture(glb, look, rng)
    light(glb)
    glb.camera("path", (-0.35, 1.5, 4.3), (0.25, 0.95, -2.0), 50)
    scene.save(glb)


if __name__ == "__main__":
    main()
