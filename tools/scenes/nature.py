"""Plants, ground and sky: trees, hedges, tufts, stones, a pot plant. Trees' leaves are cards; whether they wear a
cut-out picture or are cut as lozenges is the scene's choice."""

import numpy as np

import shapes
from forms import cushion, sheet, surface, swept

SQUARE = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * 0.5
LOZENGE = np.array([(0, -0.5), (0.22, 0.0), (0, 0.5), (-0.22, 0.0)])


def cards(centers, facings, sizes, rng, outline=SQUARE):
    """A flat four-cornered card at each centre, turned at random about its facing; without normals, as there are
    many and they are flat."""
    n = facings / np.linalg.norm(facings, axis=1, keepdims=True)
    u = np.cross(rng.normal(size=n.shape), n)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(n, u)
    flat = outline[None, :, :1] * u[:, None] + outline[None, :, 1:] * v[:, None]
    p = np.asarray(centers)[:, None] + flat * np.asarray(sizes, float).reshape(-1, 1, 1)
    count = len(n)
    triangles = (np.arange(count)[:, None, None] * 4 + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)
    uvs = np.tile(np.array([0.5, 0.5]) + outline * (1, -1), (count, 1))
    return shapes.mesh(p.reshape(-1, 3), triangles, None, uvs)


def branching(rng, height, radius, levels=3, forks=3, spread=0.75, lean=0.15):
    """A trunk with branches of branches: the mesh, and where its twigs end."""
    parts, tips = [], []

    def grow(start, way, length, r, level):
        bends = [start]
        for _ in range(4):
            way = way + rng.normal(size=3) * lean * (0.35 if level == 0 else 1) + (0, 0.06 * level, 0)
            way = way / np.linalg.norm(way)
            bends.append(bends[-1] + way * length / 4)
        parts.append(swept(bends, np.linspace(r, 0.55 * r, 5), 9 if level == 0 else 6, capped=level == levels))
        if level == levels:
            tips.extend(bends[2:])
            return
        turn = rng.random() * 2 * np.pi
        for k in range(forks):
            a = turn + 2 * np.pi * (k + 0.3 * rng.random()) / forks
            side = np.cross(way, np.roll(way, 1) + 0.1)
            side /= np.linalg.norm(side)
            out = side * np.cos(a) + np.cross(way, side) * np.sin(a)
            new = way * (1 - 0.45 * spread) + out * spread
            grow(bends[-1] - way * 0.3 * r, new / np.linalg.norm(new), length * (0.62 + 0.16 * rng.random()), 0.6 * r,
                 level + 1)

    grow(np.zeros(3), np.array([0, 1.0, 0]), height, radius, 0)
    return shapes.joined(*parts), np.array(tips)


def crown(tips, rng, each=9, reach=0.35, size=0.3, outline=SQUARE):
    """Leaf cards around the twigs' ends, facing outward and up in the mean."""
    centers = np.repeat(tips, each, 0)
    centers = centers + rng.normal(size=centers.shape) * reach
    middle = tips.mean(0)
    facings = (centers - middle) * 0.6 + rng.normal(size=centers.shape) * 0.5 + (0, 0.4, 0)
    return cards(centers, facings, size * (0.7 + 0.6 * rng.random(len(centers))), rng, outline)


def thicket(low, high, count, rng, size=0.2, outline=SQUARE):
    """Cards near the surface of a box: the outside of a hedge."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    extent = high - low
    area = np.array([extent[1] * extent[2], extent[0] * extent[2], extent[0] * extent[1]])
    axis = rng.choice(3, count, p=area / area.sum())
    side = rng.integers(0, 2, count)
    side[axis == 1] = 1
    p = rng.random((count, 3)) * extent + low
    out = np.zeros((count, 3))
    rows = np.arange(count)
    out[rows, axis] = 2 * side - 1
    p[rows, axis] = np.where(side > 0, high[axis], low[axis]) + 0.05 * rng.normal(size=count)
    return cards(p, out + rng.normal(size=(count, 3)) * 0.45, size * (0.7 + 0.6 * rng.random(count)), rng, outline)


def tuft(rng, blades=14, height=0.25, lean=0.5):
    """A tuft of grass: three-cornered blades that bend outward; from both sides."""
    positions, normals = [], []
    for _ in range(blades):
        a, tall = rng.random() * 2 * np.pi, height * (0.6 + 0.5 * rng.random())
        out = np.array([np.cos(a), 0, np.sin(a)])
        side = np.array([-out[2], 0, out[0]]) * 0.03 * height * (1 + rng.random())
        root = out * 0.12 * height * rng.random()
        bend = root + out * lean * 0.3 * tall + (0, 0.65 * tall, 0)
        tip = root + out * lean * tall + (0, tall, 0)
        positions += [root - side, root + side, bend + 0.7 * side, tip, bend - 0.7 * side]
        normals += [out + (0, 0.5, 0)] * 5
    base = np.arange(blades)[:, None, None] * 5
    triangles = (base + np.array([[0, 2, 1], [0, 4, 2], [4, 3, 2]])).reshape(-1, 3)
    normals = np.array(normals)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return shapes.mesh(positions, triangles, normals, np.zeros((len(positions), 2)))


def stone(rng, size):
    """A pebble or boulder, lying on y = 0."""
    m = cushion(size, 0.75, 8, 14)
    p = m["positions"].astype(float)
    wobble = sum(np.sin(p @ rng.normal(size=3) * 5 / max(size) + rng.random() * 6) for _ in range(4))
    p[:, [0, 2]] *= 1 + 0.05 * wobble[:, None]
    return dict(m, positions=p.astype(np.float32))


def ground(half, height, cells=48):
    """An uneven lawn, a square of `half` extent; `height(x, z)` in metres."""
    x, z = np.meshgrid(*[np.linspace(-half, half, cells + 1)] * 2, indexing="ij")
    return sheet(np.stack([x, height(x, z), z], 2).transpose(1, 0, 2), uvs=np.stack([x, z], 2).transpose(1, 0, 2) / 2)


def dome(radius, base=0.0, rows=6, columns=24):
    """A sky of few triangles, its front inside; texture coordinates run around and from the zenith down."""
    h, a = np.meshgrid(np.linspace(np.pi / 2, 0, rows + 1), np.linspace(0, 2 * np.pi, columns + 1), indexing="ij")
    p = radius * np.stack([np.cos(h) * np.cos(a), np.sin(h), np.cos(h) * np.sin(a)], 2) + (0, base, 0)
    uvs = np.stack([a / (2 * np.pi), 1 - h / (np.pi / 2)], 2)
    return sheet(p, uvs)


def plant(rng, leaves=26, size=0.3, pot=(0.11, 0.2)):
    """A pot with a spray of long leaves, to be seen from both sides."""
    radius, height = pot
    piece = dict(pot=shapes.lathe([(0, 0), (0.72 * radius, 0)], [(0.72 * radius, 0), (radius, height)],
                                  [(radius, height), (radius - 0.012, height)],
                                  [(radius - 0.012, height), (radius - 0.016, height - 0.03)], segments=24),
                 earth=shapes.disc(radius - 0.014, height - 0.02, 16))
    parts = []
    for i in range(leaves):
        turn, rise, long_ = i * 137.5, rng.uniform(0.25, 1.25), size * rng.uniform(0.7, 1.3)

        def point(s, t, rise=rise, long_=long_):
            wide = 0.11 * long_ * np.sin(np.pi * (0.08 + 0.9 * t)) ** 0.8
            out = long_ * (t * np.cos(rise) + 0.25 * t**2)
            up = long_ * (1.1 * t * np.sin(rise) + 0.35 * t - 0.75 * t**2 * np.cos(rise))
            return (2 * s - 1) * wide, up + 0.25 * wide * np.abs(2 * s - 1), 0.012 + out
        parts.append(shapes.moved(surface(point, 2, 7), (0, height - 0.025, 0), turn))
    return {**piece, "leaves": shapes.joined(*parts)}
