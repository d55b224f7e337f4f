"""Parts of buildings: arches, vaults, pierced walls, columns, balusters. Walls stand in the x-y plane, their middle at
z = 0; texture coordinates are metres in multiples of `tiles`."""

import numpy as np

import shapes
from forms import sheet


def arch_panel(width, height, radius, springing, thickness, tiles=1.0, segments=20):
    """A bay of an arcade above its columns: a wall from `springing` up to `height` with a round arch cut out.
    Its lower ends and its soffit are closed, its sides and top meet the neighbours."""
    a = np.linspace(np.pi, 0, segments + 1)
    arc = np.stack([radius * np.cos(a), springing + radius * np.sin(a)], 1)
    # Above the arc: the same number of points along the sides and the top, by angle, corners included.
    corner = np.arctan2(height - springing, width / 2)
    a = a.copy()
    for target in (np.pi - corner, corner):
        a[np.argmin(np.abs(a - target))] = target
    reach = np.minimum(width / 2 / np.maximum(np.abs(np.cos(a)), 1e-9),
                       (height - springing) / np.maximum(np.sin(a), 1e-9))
    rim = np.stack([reach * np.cos(a), springing + reach * np.sin(a)], 1)
    at = lambda xy, z: np.concatenate([xy, np.full((len(xy), 1), z)], 1)
    half = thickness / 2
    face = sheet(np.stack([at(rim, half), at(arc, half)]))
    face["uvs"] = (face["positions"][:, :2] * (1, -1) / tiles).astype(np.float32)
    face["normals"][:] = (0, 0, 1)
    soffit = sheet(np.stack([at(arc, half), at(arc, -half)]), tiles=tiles)
    foot = width / 2 - radius
    feet = [shapes.quad((x, springing, -half), (foot, 0, 0), (0, 0, thickness), (foot / tiles, thickness / tiles))
            for x in (-width / 2, radius)]
    return shapes.joined(face, mirrored(face), soffit, *feet)


def mirrored(m):
    """The same, behind: turned half round about +y."""
    turn = (-1, 1, -1)
    return shapes.mesh(m["positions"] * turn, m["triangles"], m["normals"] * turn, m["uvs"])


def archivolt(radius, springing, width, depth, segments=20):
    """A raised band around an arch, its back at z = 0."""
    a = np.linspace(0, np.pi, segments + 1)
    arc = lambda r, z: np.stack([r * np.cos(a), springing + r * np.sin(a), np.full_like(a, z)], 1)
    inner, outer = radius - 0.004, radius + width
    lines = [arc(inner, 0), arc(inner, depth), arc((inner + outer) / 2, depth * 1.35), arc(outer, depth), arc(outer, 0)]
    return shapes.joined(*(sheet(np.stack(pair)) for pair in zip(lines, lines[1:])))


def groin_vault(width, depth, rise, cells=8, tiles=1.0):
    """Two crossed barrels over a bay, seen from below; springs at y = 0, middle at the origin. Four webs, smooth each:
    the groins between them are edges."""
    s = np.sin(np.linspace(-np.pi / 2, np.pi / 2, 2 * cells + 1))[:, None]
    t = np.abs(s) + (1 - np.abs(s)) * np.linspace(0, 1, cells // 2 + 1)
    s = np.broadcast_to(s, t.shape)
    webs = []
    for turn in range(4):
        half = np.array((width, depth) if turn % 2 == 0 else (depth, width)) / 2
        p = np.stack([s * half[0], np.sqrt(np.clip(1 - s**2, 0, 1)) * rise, t * half[1]], 2)
        inward = np.stack([-s / half[0], -np.sqrt(np.clip(1 - s**2, 0, 1)) / rise, 0 * s], 2)
        web = sheet(p, uvs=p[..., [0, 2]] / tiles)
        normals = (inward / np.linalg.norm(inward, axis=2, keepdims=True)).reshape(-1, 3)
        webs.append(shapes.moved(dict(web, normals=normals.astype(np.float32)), turn_y=90 * turn))
    return shapes.joined(*webs)


def frame(inner, outer, low, high, tiles=1.0):
    """A rectangular ring around the y axis from half extents `inner` to `outer` (x, z), of four boxes."""
    (a, b), (c, d) = inner, outer
    return shapes.joined(*(shapes.box((x0, low, z0), (x1, high, z1), tiles) for x0, z0, x1, z1 in (
        (-c, -d, c, -b), (-c, b, c, d), (-c, -b, -a, b), (a, -b, c, b))))


def pierced_wall(width, height, thickness, holes, tiles=1.0):
    """A wall from x = 0 on with rectangular holes (x0, y0, x1, y1); a grid through all edges, so that nothing gaps."""
    xs = sorted({0.0, width, *(h[k] for h in holes for k in (0, 2))})
    ys = sorted({0.0, height, *(h[k] for h in holes for k in (1, 3))})
    inside = lambda x, y: any(a < x < c and b < y < d for a, b, c, d in holes)
    solid = [[not inside((a + b) / 2, (c + d) / 2) for c, d in zip(ys, ys[1:])] for a, b in zip(xs, xs[1:])]
    filled = lambda i, j: 0 <= i < len(xs) - 1 and 0 <= j < len(ys) - 1 and solid[i][j]
    half, parts = thickness / 2, []

    def face(corner, u, v):
        q = shapes.quad(corner, u, v)
        axis = np.argmax(np.abs(q["normals"][0]))
        pick = ([2, 1], [0, 2], [0, 1])[axis]
        q["uvs"] = (q["positions"][:, pick] * (1, -1) / tiles).astype(np.float32)
        parts.append(q)

    for i, (a, b) in enumerate(zip(xs, xs[1:])):
        for j, (c, d) in enumerate(zip(ys, ys[1:])):
            if not solid[i][j]:
                continue
            right, up, back = (b - a, 0, 0), (0, d - c, 0), (0, 0, -thickness)
            face((a, c, half), right, up)
            face((b, c, -half), (a - b, 0, 0), up)
            if not filled(i - 1, j):
                face((a, c, -half), (0, 0, thickness), up)
            if not filled(i + 1, j):
                face((b, c, half), back, up)
            if not filled(i, j - 1):
                face((a, c, -half), right, (0, 0, thickness))
            if not filled(i, j + 1):
                face((a, d, half), right, back)
    return shapes.joined(*parts)


def column(height, radius, segments=20):
    """A round column with base and capital; plinth and abacus are square. Stands on y = 0."""
    r, plinth, cap = radius, 0.45 * radius, 0.4 * radius
    y, top = plinth, height - cap
    base = [(1.32 * r, y), (1.42 * r, y + 0.12 * r), (1.36 * r, y + 0.26 * r), (1.16 * r, y + 0.34 * r),
            (1.1 * r, y + 0.46 * r), (1.2 * r, y + 0.56 * r), (1.1 * r, y + 0.66 * r), (r, y + 0.74 * r)]
    shaft = [(r, y + 0.74 * r), (1.01 * r, height * 0.35), (0.97 * r, height * 0.6), (0.86 * r, top - 1.9 * r)]
    bell = [(0.86 * r, top - 1.9 * r), (0.98 * r, top - 1.82 * r), (0.98 * r, top - 1.7 * r),
            (0.88 * r, top - 1.62 * r),
            (0.9 * r, top - 1.2 * r), (1.02 * r, top - 0.75 * r), (1.3 * r, top - 0.25 * r), (1.36 * r, top)]
    square = lambda half, low, high: shapes.box((-half, low, -half), (half, high, half))
    return shapes.joined(square(1.45 * r, 0, plinth), shapes.lathe(base, shaft, bell, segments=segments),
                         square(1.45 * r, top, height))


def leafy_collar(radius, height, leaves=7, rows=2):
    """Curled leaves around a capital's bell, which they hide: what makes it Corinthian. Seen from both sides."""
    parts = []
    for row in range(rows):
        for k in range(leaves):
            s, w = np.meshgrid(np.linspace(0, 1, 5), np.linspace(-1, 1, 4), indexing="ij")
            half = 0.34 * radius * np.sqrt(np.clip(1 - s**3, 0.03, 1)) * w
            out = radius * (1.0 + 0.05 * row + 0.42 * s**3) - 0.1 * radius * w**2
            up = height * (0.45 * row + 0.62 * s - 0.24 * np.maximum(s - 0.75, 0) * 4 * s)
            leaf = sheet(np.stack([half, up, out], 2))
            parts.append(shapes.moved(leaf, turn_y=360 / leaves * (k + 0.5 * row)))
    return shapes.joined(*parts)


def baluster(height, radius, segments=8):
    profile = [(0.6, 0.0), (0.6, 0.08), (0.45, 0.12), (0.8, 0.25), (1.0, 0.38), (0.8, 0.52), (0.42, 0.72),
               (0.4, 0.86), (0.6, 0.92), (0.6, 1.0)]
    return shapes.lathe([(r * radius, y * height) for r, y in profile], segments=segments)


def steps_of(profile, length):
    """A cornice: boxes (low y, high y, reach) stacked, sticking out towards +z from a wall at z = 0."""
    boxes = [shapes.box((-length / 2, low, -0.05), (length / 2, high, reach)) for low, high, reach in profile]
    return shapes.joined(*boxes)


def drape(width, height, folds=5, swell=0.06, rows=24, columns=60, gather=0.0, seed=0):
    """A hanging cloth in folds, its top edge along x at y = 0; to be worn doubleSided. `gather` draws its foot in."""
    rng = np.random.default_rng(seed)
    s, t = np.meshgrid(np.linspace(0, 1, rows + 1), np.linspace(0, 1, columns + 1), indexing="ij")
    phase = rng.random(3) * 6.28
    deep = 0.35 + 0.65 * np.sqrt(s)
    z = swell * deep * (np.sin(2 * np.pi * folds * t + phase[0] + 0.8 * s)
                        + 0.35 * np.sin(2 * np.pi * folds * 2.3 * t + phase[1] - 1.3 * s))
    x = (t - 0.5) * width * (1 - gather * np.sin(np.pi * np.clip(s * 1.15, 0, 1)) ** 2)
    y = -height * s - 0.02 * height * s * np.sin(2 * np.pi * 1.5 * t + phase[2])
    return sheet(np.stack([x, y, z], 2), uvs=np.stack([t, s * height / width], 2))
