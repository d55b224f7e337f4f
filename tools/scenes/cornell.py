#!/usr/bin/env python3
"""Makes scenes/cornell.glb: the Cornell box with its published measures, the easy control of the benchmark. All of it is
Lambert, the lamp lights most of what is seen directly: nothing here is worth learning, so it shows what a method costs.

    python3 tools/scenes/cornell.py [OUT.glb]
"""

import numpy as np

import scene
import shapes
from looks import lit, matte

WIDTH, HEIGHT, DEPTH = 0.5528, 0.5488, 0.5592
SHORT_BLOCK = ((130, 65), (82, 225), (240, 272), (290, 114))  # x, z of the corners in millimetres
TALL_BLOCK = ((423, 247), (265, 296), (314, 456), (472, 406))


def block(corners, height):
    """A prism on the floor: its top and four sides; what lies on the floor needs no underside."""
    floor = np.array([(x, 0, z) for x, z in corners]) / 1000
    top = floor + (0, height, 0)
    faces = [shapes.quad(top[0], top[1] - top[0], top[3] - top[0])]
    faces[0]["positions"][:] = top  # the published corners are no exact rectangle
    for a, b in zip(floor, np.roll(floor, -1, 0)):
        faces.append(shapes.quad(a, b - a, (0, height, 0)))
    return shapes.joined(*faces)


def main():
    glb = scene.begin("cornell", (400, 400))
    white = matte(glb, "white", (0.74, 0.73, 0.7))
    red, green = matte(glb, "red", (0.57, 0.045, 0.04)), matte(glb, "green", (0.11, 0.37, 0.075))
    lamp = lit(glb, "lamp", 45.0, (1.0, 0.76, 0.46))
    x, y, z = np.diag((WIDTH, HEIGHT, DEPTH))
    glb.add("floor", shapes.quad(z, x, -z), white)
    glb.add("ceiling", shapes.quad(y, x, z), white)
    glb.add("back wall", shapes.quad(x + z, -x, y), white)
    glb.add("red wall", shapes.quad(x, z, y), red)
    glb.add("green wall", shapes.quad(z, -z, y), green)
    glb.add("short block", block(SHORT_BLOCK, 0.165), white)
    glb.add("tall block", block(TALL_BLOCK, 0.33), white)
    glb.add("lamp", shapes.quad((0.213, HEIGHT - 0.0005, 0.227), (0.13, 0, 0), (0, 0, 0.105)), lamp)
    glb.camera("front", (0.278, 0.273, -0.8), (0.278, 0.273, 0.0), 39.3)
    scene.save(glb)


if __name__ == "__main__":
    main()
