#!/usr/bin/env python3
"""Writes a small file that shows very many triangles: crowd.py OUT.glb [SIDE] [--dense]

A body of 768 triangles in SIDE x SIDE places (100 by default: 7.7 million triangles from 34 kB), turned and scaled, over a
ground and under a sun: SIDE nodes that share a mesh, each with SIDE places by EXT_mesh_gpu_instancing. `--dense` sets the
bodies so near to each other that each reaches into its neighbours."""

import json
import math
import random
import struct
import sys

RINGS, SEGMENTS = 13, 32


def body():
    """A knobbly ball about the origin: positions, normals and triangles."""
    radius = lambda u, v: 1.0 + 0.15 * math.sin(5 * u) * math.sin(4 * v)
    positions = [(0.0, 1.0, 0.0), (0.0, -1.0, 0.0)]
    for ring in range(1, RINGS):
        v = math.pi * ring / RINGS
        for segment in range(SEGMENTS):
            u = 2 * math.pi * segment / SEGMENTS
            r = radius(u, v)
            positions.append((r * math.sin(v) * math.cos(u), r * math.cos(v), r * math.sin(v) * math.sin(u)))
    at = lambda ring, segment: 2 + (ring - 1) * SEGMENTS + segment % SEGMENTS
    triangles = []
    for s in range(SEGMENTS):
        triangles.append((0, at(1, s + 1), at(1, s)))
        triangles.append((1, at(RINGS - 1, s), at(RINGS - 1, s + 1)))
        for ring in range(1, RINGS - 1):
            a, b, c, d = at(ring, s), at(ring, s + 1), at(ring + 1, s + 1), at(ring + 1, s)
            triangles += [(a, b, c), (a, c, d)]
    return positions, positions, triangles


def write(path, side, dense):
    chance = random.Random(7)
    binary, views, accessors = b"", [], []

    def accessor(numbers, code, component, kind, count, **more):
        nonlocal binary
        data = struct.pack(f"<{len(numbers)}{code}", *numbers)
        binary += b"\0" * (-len(binary) % 4)
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        binary += data
        view = {"bufferView": len(views) - 1, "componentType": component}
        accessors.append({**view, "count": count, "type": kind, **more})
        return len(accessors) - 1

    def flat(rows):
        return [number for row in rows for number in row]

    def bounds(rows):
        return {"min": [min(r[i] for r in rows) for i in range(3)], "max": [max(r[i] for r in rows) for i in range(3)]}

    def rounded(rows):
        return [struct.unpack("<3f", struct.pack("<3f", *row)) for row in rows]

    positions, normals, triangles = body()
    positions = rounded(positions)
    normals = [tuple(x / math.sqrt(sum(y * y for y in n)) for x in n) for n in normals]
    ball = {
        "attributes": {
            "POSITION": accessor(flat(positions), "f", 5126, "VEC3", len(positions), **bounds(positions)),
            "NORMAL": accessor(flat(normals), "f", 5126, "VEC3", len(normals)),
        },
        "indices": accessor(flat(triangles), "H", 5123, "SCALAR", 3 * len(triangles)),
        "material": 0,
    }
    half = side * 0.75
    corners = rounded([(-half, -1.5, half), (half, -1.5, half), (half, -1.5, -half), (-half, -1.5, -half)])
    ground = {
        "attributes": {"POSITION": accessor(flat(corners), "f", 5126, "VEC3", 4, **bounds(corners))},
        "indices": accessor([0, 1, 2, 0, 2, 3], "H", 5123, "SCALAR", 6),
        "material": 1,
    }
    step = 0.55 if dense else 1.0
    translations, rotations, scales = [], [], []
    for i in range(side):
        translations.append((step * (i - 0.5 * side), 0.3 * chance.random(), 0.2 * chance.random()))
        turn = [chance.gauss(0, 1) for _ in range(4)]
        length = math.sqrt(sum(x * x for x in turn))
        rotations.append([round(32767 * x / length) for x in turn])
        size = 0.3 + 0.08 * chance.random()
        scales.append((size, size * (0.7 + 0.3 * chance.random()), size if i % 3 else -size))
    places = {
        "TRANSLATION": accessor(flat(translations), "f", 5126, "VEC3", side),
        "ROTATION": accessor(flat(rotations), "h", 5122, "VEC4", side, normalized=True),
        "SCALE": accessor(flat(scales), "f", 5126, "VEC3", side),
    }
    at = lambda row: (0.3 * chance.random(), 0.4 * chance.random(), step * (row - 0.5 * side))
    nodes = [
        {"mesh": 0, "translation": [round(x, 2) for x in at(row)],
         "extensions": {"EXT_mesh_gpu_instancing": {"attributes": places}}}
        for row in range(side)
    ]
    nodes += [
        {"mesh": 1},
        {"camera": 0, "translation": [0, 6, 0.5 * step * side + 2], "rotation": [-0.2164396, 0, 0, 0.976296]},
        {"rotation": [-0.4, 0.3, 0.1, 0.86], "extensions": {"KHR_lights_punctual": {"light": 0}}},
    ]
    document = {
        "asset": {"version": "2.0", "generator": "tools/scenes/crowd.py"},
        "extensionsUsed": ["EXT_mesh_gpu_instancing", "KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 3}]}},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "meshes": [{"name": "ball", "primitives": [ball]}, {"name": "ground", "primitives": [ground]}],
        "materials": [
            {"pbrMetallicRoughness": {"baseColorFactor": color + [1], "metallicFactor": 0, "roughnessFactor": 1},
             "extensions": {"KHR_materials_specular": {"specularFactor": 0}}}
            for color in ([0.6, 0.3, 0.2], [0.3, 0.4, 0.3])
        ],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", len(binary), b"BIN\0") + binary)


if __name__ == "__main__":
    words = [word for word in sys.argv[1:] if word != "--dense"]
    if not words:
        sys.exit(__doc__)
    write(words[0], int(words[1]) if len(words) > 1 else 100, "--dense" in sys.argv)
