"""How each scene's program begins and ends, and the suns. The programs need Python 3.9 and NumPy; the same NumPy gives
the same file."""

import sys
from pathlib import Path

import numpy as np

import shapes
from forms import facing
from glb import Glb
from looks import lit


def begin(name, resolution):
    """An empty scene, to be written to scenes/NAME.glb; `resolution` is the picture's size in pixels."""
    return Glb(name, "CC0 1.0, the Halfway contributors", resolution)


def save(glb):
    """Writes scenes/NAME.glb, or the file that the command line names."""
    name = glb.json["scenes"][0]["name"]
    if not glb.json["textures"]:
        del glb.json["samplers"]
    for key in [key for key, value in glb.json.items() if value == [] and key != "buffers"]:
        del glb.json[key]  # glTF knows no empty lists
    default = Path(__file__).resolve().parents[2] / "scenes" / f"{name}.glb"
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else default
    glb.write(out)
    print(f"{out}: {out.stat().st_size / 1e6:.2f} MB")


def sun(glb, direction, strength, color):
    """A directional light that shines along `direction`; strength is irradiance across the beam."""
    forward = np.asarray(direction, float) / np.linalg.norm(direction)
    w, x, y = 1 - forward[2], forward[1], -forward[0]  # the quaternion that takes -z there
    turn = np.array([x, y, 0.0, w]) / np.linalg.norm([x, y, w])
    light = dict(name="sun", type="directional", color=[float(c) for c in color], intensity=float(strength))
    name = "KHR_lights_punctual"
    lights = glb.json.setdefault("extensions", {}).setdefault(name, dict(lights=[]))["lights"]
    lights.append(light)
    if name not in glb.json["extensionsUsed"]:
        glb.json["extensionsUsed"].append(name)
    glb.json["nodes"].append(dict(name="sun", rotation=turn.tolist(), extensions={name: dict(light=len(lights) - 1)}))
    glb.json["scenes"][0]["nodes"].append(len(glb.json["nodes"]) - 1)


def sun_disc(glb, center, toward, radius, irradiance, color, corners=12):
    """A sun with a surface, before a sky that is one: gives `irradiance` across the beam at the origin."""
    a = np.linspace(0, 2 * np.pi, corners, endpoint=False)
    frame = facing(toward)
    rim = radius * (np.cos(a)[:, None] * frame[0] + np.sin(a)[:, None] * frame[1])
    triangles = [(0, k, k + 1) for k in range(1, corners - 1)]
    area = corners / 2 * np.sin(2 * np.pi / corners) * radius**2
    radiance = irradiance * (np.linalg.norm(center) ** 2) / area
    disc = shapes.mesh(rim, triangles, [frame[2]] * corners, [(0, 0)] * corners)
    glb.add("sun", disc, lit(glb, "sun", float(radiance), color), center)
