"""Materials and small textures that the scenes share: (height, width, 3) sRGB pictures that repeat."""

import numpy as np

import pictures
from pictures import blend, noise, plane, smooth


def matte(glb, name, base=(1, 1, 1), **more):
    """A Lambert surface: without the 4 % of gloss that glTF gives a dielectric by default."""
    return glb.material(name, base, extensions=dict(KHR_materials_specular=dict(specularFactor=0.0)), **more)


def printed(glb, name, picture, tint=(1, 1, 1), **more):
    """A Lambert surface that wears a picture."""
    return matte(glb, name, tint, textures=glb.texture(name, picture), **more)


def lit(glb, name, strength, color=(1, 1, 1), picture=None, **more):
    """A surface that shines with `strength` times its colour, and its picture if it has one."""
    if picture is not None:
        more["emissiveTexture"] = glb.texture(name, picture)
    extensions = dict(KHR_materials_emissive_strength=dict(emissiveStrength=strength),
                      KHR_materials_specular=dict(specularFactor=0.0))
    return glb.material(name, (0, 0, 0), emissiveFactor=[float(c) for c in color], extensions=extensions, **more)


def cloudy(light, dark, cells=8, size=128, seed=0, contrast=1.0):
    """Two colours in soft blots of three sizes: plaster, earth, rough cloth."""
    share = sum(noise(size, size, (cells * 2**k,) * 2, seed + k) * w for k, w in enumerate((0.5, 0.3, 0.2)))
    return blend(light, dark, np.clip((share - 0.5) * 1.6 * contrast + 0.5, 0, 1))


def blocks(light, dark, joint, rows, columns, size=256, seed=0, gap=0.012, shift=0.5):
    """Courses of stones, each of its own shade, every other one shifted; bricks and floor slabs alike."""
    x, y = plane(size, size)
    row = np.floor(y * rows).astype(int)
    across = x * columns + shift * (row % 2)
    shades = np.random.default_rng(seed).random((rows, columns))
    shade = shades[row, np.floor(across).astype(int) % columns]
    grain = noise(size, size, (size // 4,) * 2, seed + 1)
    stone = blend(light, dark, np.clip(0.55 * shade + 0.45 * grain, 0, 1))
    edge_x = np.abs((across + 0.5) % 1 - 0.5) / columns
    edge_y = np.abs((y * rows + 0.5) % 1 - 0.5) / rows
    return blend(stone, joint, 1 - smooth(gap / 2, np.minimum(edge_x, edge_y), gap / 2))


def planks(light, dark, boards=6, size=256, seed=0):
    """Boards along x with grain, dark between them."""
    grain = pictures.wood(size, size, light, dark, seed)
    _, y = plane(size, size)
    shades = 0.82 + 0.18 * np.random.default_rng(seed).random(boards)
    grain = grain * shades[np.floor(y * boards).astype(int)][..., None]
    edge = np.abs((y * boards + 0.5) % 1 - 0.5) / boards
    return blend(grain, np.asarray(dark) * 0.45, 1 - smooth(0.004, edge, 0.004))


def damask(ground, figure, trim, size=128):
    """A woven cloth with lozenges, and a trim of stripes at its sides."""
    x, y = plane(size, size)
    wave = np.cos(2 * np.pi * (3 * x + 2 * y)) * np.cos(2 * np.pi * (3 * x - 2 * y))
    cloth = blend(ground, figure, smooth(0.45, wave, 0.2))
    side = np.minimum(x, 1 - x)
    return blend(cloth, trim, smooth(0.03, side, 0.01) * (1 - smooth(0.075, side, 0.01)))


def sky(zenith, horizon, size=128, clouds=0.5, seed=3):
    """Sky from the zenith (top) to the horizon (bottom) with a few soft clouds; wraps across."""
    _, y = plane(2 * size, size)
    clear = blend(zenith, horizon, np.clip(y, 0, 1) ** 1.5)
    puffs = sum(noise(2 * size, size, (6 * 2**k, 6 * 2**k), seed + k) * w for k, w in enumerate((0.5, 0.3, 0.2)))
    return blend(clear, [1, 1, 1], clouds * smooth(0.58, puffs, 0.25))
