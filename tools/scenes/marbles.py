#!/usr/bin/env python3
"""Makes scenes/marbles.glb, the demo scene: a game of marbles by the window at dusk, watched by a family of ducks.

Everything is made here, shapes and pictures alike.

    python3 tools/scenes/marbles.py [OUT.glb]
"""

from itertools import cycle

import numpy as np

import forms
import pictures
import scene
import shapes
from looks import glowing, matte, printed

MARBLE = 0.0125  # radius
DUCK, DUCK_SCALE = (0.235, 0, 0.0), 1.25


def smooth_min(a, b, k):
    """The smaller one, rounded over a width of `k` where the two are close."""
    h = np.maximum(k - np.abs(a - b), 0) / k
    return np.minimum(a, b) - h * h * k / 4


def ellipsoid(p, center, radii):
    """A signed distance near enough to an ellipsoid's for a smooth union."""
    q = (p - np.asarray(center, float)) / radii
    k0 = np.linalg.norm(q, axis=1)
    k1 = np.linalg.norm(q / radii, axis=1)
    return k0 * (k0 - 1) / np.maximum(k1, 1e-9)


def duck_body(p):
    """The distance to a bath duck's body in centimetres; it faces +x and stands on y = 0."""
    p = np.stack([p[:, 0], p[:, 1], np.abs(p[:, 2])], 1)
    body = ellipsoid(p, (0, 2.9, 0), (4.3, 3.0, 3.3))
    tail = ellipsoid(p, (-4.1, 4.5, 0), (1.1, 0.7, 0.9))
    head = ellipsoid(p, (2.4, 7.0, 0), (2.35, 2.25, 2.25))
    wing = ellipsoid(p, (-0.7, 3.6, 2.9), (2.3, 1.3, 0.7))
    duck = smooth_min(smooth_min(body, tail, 2.2), head, 1.1)
    return np.maximum(smooth_min(duck, wing, 0.5), 0.25 - p[:, 1])


def bill(p):
    upper = ellipsoid(p, (4.9, 6.75, 0), (1.25, 0.36, 1.05))
    lower = ellipsoid(p, (4.65, 6.3, 0), (1.0, 0.28, 0.85))
    return smooth_min(upper, lower, 0.25)


def cats_eye(radius, twist=1.7):
    """Three twisted blades, the ribbon inside a glass marble; to be seen from both sides."""
    t = np.linspace(-1, 1, 13)
    positions, triangles = [], []
    for blade in range(3):
        angle = blade * 2 * np.pi / 3 + twist * t
        width = 0.68 * np.sqrt(1 - t**2)
        base = len(positions)
        for along, a, w in zip(t * 0.72, angle, width):
            positions += [(along, 0, 0), (along, w * np.cos(a), w * np.sin(a))]
        for i in range(len(t) - 1):
            a, b, c, d = (base + 2 * i + k for k in range(4))
            triangles += [(a, b, d), (a, d, c)]
    positions = np.array(positions) * radius
    triangles = np.array(triangles)
    corners = positions[triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return shapes.mesh(positions, triangles[area > 1e-3 * area.max()])


def glass(glb, name, tint):
    volume = dict(thicknessFactor=2 * MARBLE, attenuationColor=list(tint), attenuationDistance=2 * MARBLE)
    return glb.material(name, roughness=0.0, extensions=dict(
        KHR_materials_transmission=dict(transmissionFactor=1.0),
        KHR_materials_volume=volume, KHR_materials_ior=dict(ior=1.52)))


def room(glb):
    """A closed room; the window at the back shows the evening, a bright one beside the camera fills the shadows."""
    bumps = dict(normalTexture=glb.texture("plaster", pictures.plaster()))
    wall = matte(glb, "wall", (0.62, 0.66, 0.58), **bumps)
    plain = matte(glb, "ceiling", (0.8, 0.78, 0.74))
    boards = matte(glb, "floor", (0.3, 0.2, 0.13))
    frame = glb.material("window frame", (0.82, 0.8, 0.76), roughness=0.45)
    low, high = np.array([-1.5, -0.75, -0.55]), np.array([1.5, 1.6, 2.2])
    x, y, z = np.diag(high - low)
    back = shapes.quad(low, x, y, (15, 12))
    back["tangents"] = np.tile(np.float32([1, 0, 0, 1]), (4, 1))
    glb.add("back wall", back, wall)
    glb.add("left wall", shapes.quad(low + z, -z, y, (14, 12)), plain)
    glb.add("right wall", shapes.quad(low + x, z, y, (14, 12)), plain)
    glb.add("front wall", shapes.quad(low + z + x, -x, y, (15, 12)), plain)
    glb.add("ceiling", shapes.quad(low + y + z, x, -z), plain)
    glb.add("floor", shapes.quad(low + z, x, -z), boards)

    def window(name, corner, u, v, material, out):
        """A pane, a frame around it and a cross in it; `out` points into the room."""
        corner, u, v, out = (np.asarray(a, float) for a in (corner, u, v, out))
        glb.add(name, shapes.quad(corner + 0.004 * out, u, v), material)
        bar, across, upward = 0.018, u / np.linalg.norm(u), v / np.linalg.norm(v)
        parts = []
        # Start, length, thickness and depth of each bar; no two faces in one plane.
        for start, along, thick, depth in (
            (corner - bar * across - bar * upward, u + 2 * bar * across, bar * upward, 0.024),
            (corner + v - bar * across, u + 2 * bar * across, bar * upward, 0.024),
            (corner - bar * across, v, bar * across, 0.022),
            (corner + u, v, bar * across, 0.022),
            (corner + u / 2 - 0.35 * bar * across, v, 0.7 * bar * across, 0.018),
            (corner + v / 2 - 0.35 * bar * upward, u, 0.7 * bar * upward, 0.014),
        ):
            ends = np.stack([start, start + along + thick + depth * out])
            parts.append(shapes.box(ends.min(0), ends.max(0)))
        glb.add(name + " frame", shapes.joined(*parts), frame)

    evening = glowing(glb, "evening", 1.8, emissiveTexture=glb.texture("dusk", pictures.dusk()))
    window("window", (-0.57, 0.06, low[2]), (0.56, 0, 0), (0, 0.4, 0), evening, (0, 0, 1))
    glb.add("sill", shapes.box((-0.63, 0.015, low[2]), (0.05, 0.042, low[2] + 0.06)), frame)
    daylight = glowing(glb, "daylight", 6.0, color=(0.78, 0.88, 1.0))
    window("side window", (low[0], 0.1, 1.5), (0, 0, -1.1), (0, 1.1, 0), daylight, (1, 0, 0))

    art = glb.material("print", roughness=0.6, textures=glb.texture("poster", pictures.poster()))
    oak = glb.material("oak", (0.3, 0.19, 0.1), roughness=0.5)
    left, bottom, width, height = 0.1, 0.085, 0.165, 0.22
    glb.add("picture", shapes.quad((left, bottom, low[2] + 0.012), (width, 0, 0), (0, height, 0)), art)
    rim = 0.012
    right, top = left + width, bottom + height
    bars = [((left - rim, bottom - rim), (right + rim, bottom)), ((left - rim, top), (right + rim, top + rim)),
            ((left - rim, bottom), (left, top)), ((right, bottom), (right + rim, top))]
    glb.add("picture frame", shapes.joined(*(
        shapes.box((*a, low[2]), (*b, low[2] + 0.02)) for a, b in bars)), oak)


def table(glb):
    cloth = printed(glb, "gingham", pictures.gingham())
    wood = glb.material("walnut", (0.42, 0.27, 0.17), roughness=0.4)
    glb.add("table", shapes.box((-0.8, -0.04, -0.5), (0.8, -0.002, 0.5)), wood)
    glb.add("cloth", shapes.quad((-0.78, 0, 0.48), (1.56, 0, 0), (0, 0, -0.96), (26, 16)), cloth)


def lamp(glb, offset):
    brass = glb.material("brass", (0.91, 0.74, 0.42), metallic=1.0, roughness=0.22)
    cloth = glowing(glb, "lamp shade", 6.0, doubleSided=True, emissiveTexture=glb.texture("shade", pictures.shade()))
    foot = shapes.lathe([(0.058, 0.0), (0.058, 0.006)],
                        [(0.058, 0.006), (0.05, 0.012), (0.025, 0.018), (0.012, 0.03), (0.008, 0.05), (0.014, 0.075),
                         (0.018, 0.09), (0.014, 0.105), (0.007, 0.12), (0.006, 0.15), (0.006, 0.2), (0.006, 0.26)])
    glb.add("lamp foot", foot, brass, offset)
    glb.add("lamp shade", shapes.lathe([(0.115, 0.16), (0.097, 0.22), (0.08, 0.28), (0.07, 0.315)]), cloth, offset)


def cup(glb, offset):
    """A cup of tea on its saucer."""
    china = glb.material("china", roughness=0.12, textures=glb.texture("stripes", pictures.stripes()))
    plain = glb.material("saucer", (0.92, 0.91, 0.87), roughness=0.12)
    tea = glb.material("tea", (0.32, 0.1, 0.025), roughness=0.05)
    outside = [(0.022, 0.012), (0.026, 0.016), (0.034, 0.028), (0.039, 0.045), (0.041, 0.062), (0.042, 0.07)]
    lip = [(0.042, 0.07), (0.0415, 0.0714), (0.0405, 0.0714), (0.04, 0.07)]
    inside = [(0.04, 0.07), (0.039, 0.062), (0.037, 0.045), (0.032, 0.03), (0.022, 0.018), (0.0, 0.016)]
    glb.add("cup", shapes.lathe([(0.0, 0.012), (0.022, 0.012)], outside, lip, inside), china, offset)
    t = np.linspace(-0.62 * np.pi, 0.62 * np.pi, 24)
    handle = np.stack([0.038 + 0.019 * np.cos(t) * 1.1, 0.043 + 0.021 * np.sin(t), 0 * t], 1)
    glb.add("handle", forms.tube(handle, 0.0036), plain, offset, turn_y=-40)
    glb.add("tea", shapes.lathe([(0.0395, 0.061), (0.02, 0.061), (0.0, 0.061)]), tea, offset)
    saucer = shapes.lathe([(0.0, 0.001), (0.03, 0.001), (0.03, 0.003), (0.05, 0.008), (0.068, 0.014)],
                          [(0.068, 0.014), (0.069, 0.0155), (0.067, 0.016)],
                          [(0.067, 0.016), (0.05, 0.0105), (0.032, 0.0065), (0.0, 0.0062)])
    glb.add("saucer", saucer, plain, offset)


def ducks(glb):
    yellow = glb.material("duck", (0.95, 0.66, 0.08), roughness=0.16)
    orange = glb.material("bill", (0.86, 0.27, 0.04), roughness=0.25)
    black = glb.material("eye", (0.015, 0.015, 0.018), roughness=0.04)
    centimetre = 0.01
    body = shapes.moved(shapes.isosurface(duck_body, (-6, -0.2, -4.4), (5.6, 10, 4.4), 56), scale=centimetre)
    beak = shapes.moved(shapes.isosurface(bill, (3, 5.6, -1.5), (6.6, 7.6, 1.5), 26), scale=centimetre)
    ball = shapes.stretched(shapes.sphere(1.0, 2), (0.36, 0.46, 0.3))
    eyes = shapes.moved(shapes.joined(*(shapes.moved(ball, (3.85, 7.7, side * 1.52)) for side in (-1, 1))),
                        scale=centimetre)

    def duck(name, offset, turn_y, scale):
        for part, m, material in (("", body, yellow), (" bill", beak, orange), (" eyes", eyes, black)):
            glb.add(name + part, m, material, offset, turn_y, scale)

    duck("duck", DUCK, 212, DUCK_SCALE)
    for i, (offset, turn_y) in enumerate((((0.15, 0, 0.2), 165), ((0.235, 0, 0.225), 130), ((-0.285, 0, 0.23), 30))):
        duck(f"duckling {i + 1}", offset, turn_y, 0.5)


def marbles(glb, center, rng):
    """English solitaire, one move into the game, on a turned board."""
    grain = glb.texture("board", pictures.wood(256, 256, [0.72, 0.5, 0.3], [0.5, 0.31, 0.17], 11))
    wood = glb.material("board", roughness=0.35, textures=grain)
    top = 0.02
    board = shapes.lathe([(0.16, 0.0), (0.166, 0.005), (0.168, 0.011), (0.166, 0.016), (0.162, 0.0195), (0.157, top)],
                         [(0.157, top), (0.154, 0.0165), (0.148, 0.014), (0.142, 0.0165), (0.139, top)],
                         [(0.139, top), (0.07, top), (0.0, top)], segments=96)
    board["uvs"] = np.ascontiguousarray(board["positions"][:, [0, 2]] / 0.34 + 0.5, np.float32)
    glb.add("board", board, wood, center)

    ball, blades = shapes.sphere(MARBLE, 3), cats_eye(MARBLE)
    clear = glass(glb, "clear glass", (0.93, 0.97, 0.95))
    tinted = cycle([glass(glb, name, tint) for name, tint in (
        ("green glass", (0.25, 0.75, 0.4)), ("blue glass", (0.2, 0.45, 0.85)),
        ("amber glass", (0.95, 0.55, 0.12)))])
    ribbon = cycle([matte(glb, f"{name} ribbon", color, doubleSided=True) for name, color in (
        ("red", (0.8, 0.06, 0.05)), ("blue", (0.06, 0.2, 0.75)), ("green", (0.06, 0.5, 0.15)),
        ("yellow", (0.9, 0.6, 0.05)), ("white", (0.9, 0.9, 0.88)))])
    metals = cycle([glb.material("steel", (0.62, 0.62, 0.64), metallic=1.0, roughness=0.06),
                    glb.material("gold", (1.0, 0.77, 0.34), metallic=1.0, roughness=0.18)])
    glazes = cycle([glb.material(f"{name} glaze", color, roughness=0.1) for name, color in (
        ("red", (0.62, 0.04, 0.04)), ("teal", (0.03, 0.35, 0.36)), ("cream", (0.85, 0.8, 0.68)))])

    def marble(name, at, kind):
        turn = rng.normal(size=4)
        turn /= np.linalg.norm(turn)
        if kind < 0.58:
            glb.add(name, ball, clear, at)
            glb.add(name + " ribbon", blades, next(ribbon), at, rotation=turn)
        elif kind < 0.76:
            glb.add(name, ball, next(tinted), at)
        elif kind < 0.86:
            glb.add(name, ball, next(metals), at)
        else:
            glb.add(name, ball, next(glazes), at)

    on_its_head = (DUCK[0] - 0.022 * DUCK_SCALE, 0.092 * DUCK_SCALE + 0.95 * MARBLE, DUCK[2] + 0.014)
    marble("taken marble", on_its_head, 0.9)
    spacing = 0.0335
    holes = [(i, j) for j in range(-3, 4) for i in range(-3, 4) if abs(i) < 2 or abs(j) < 2]
    empty = {(0, 1), (0, 2)}  # the first move: two steps to the middle, over the one that is gone
    turn = np.radians(12)
    for i, j in holes:
        kind = rng.random()
        if (i, j) in empty:
            continue
        x, z = (spacing * (i * np.cos(turn) + j * np.sin(turn)), spacing * (j * np.cos(turn) - i * np.sin(turn)))
        marble(f"marble {i} {j}", (center[0] + x, top + 0.72 * MARBLE, center[2] + z), kind)
    loose = ((-0.19, 0.255, 0.1), (0.035, 0.285, 0.7), (-0.075, 0.27, 0.8), (-0.3, 0.1, 0.65))
    for i, (x, z, kind) in enumerate(loose):
        marble(f"loose marble {i + 1}", (x, MARBLE, z), kind)


def main():
    glb = scene.begin("marbles", (640, 400))
    room(glb)
    table(glb)
    lamp(glb, (0.4, 0, -0.3))
    cup(glb, (-0.3, 0, -0.12))
    ducks(glb)
    marbles(glb, (-0.04, 0.0, 0.06), np.random.default_rng(7))
    glb.camera("table", (-0.02, 0.33, 0.92), (0.0, 0.078, 0.0), 29)
    glb.camera("duck", (0.0, 0.13, 0.42), (0.17, 0.06, 0.02), 32)
    scene.save(glb)


if __name__ == "__main__":
    main()
