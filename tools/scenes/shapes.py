"""Meshes for our scenes. A mesh is a dict: positions (n,3), triangles (m,3), normals (n,3) or None for flat
shading, uvs (n,2) or None; sometimes tangents (n,4). Lengths in metres, +y up, fronts counter-clockwise."""

import numpy as np


def mesh(positions, triangles, normals=None, uvs=None):
    as_array = lambda values, kind: None if values is None else np.asarray(values, kind)
    return dict(positions=as_array(positions, np.float32), triangles=as_array(triangles, np.uint32),
                normals=as_array(normals, np.float32), uvs=as_array(uvs, np.float32))


def joined(*meshes):
    """One mesh of several that agree on which attributes they have."""
    base = np.cumsum([0] + [len(m["positions"]) for m in meshes])
    stack = lambda key: None if meshes[0][key] is None else np.concatenate([m[key] for m in meshes])
    triangles = np.concatenate([m["triangles"] + b for m, b in zip(meshes, base)])
    return mesh(stack("positions"), triangles, stack("normals"), stack("uvs"))


def moved(m, offset=(0, 0, 0), turn_y=0.0, scale=1.0):
    """Scaled, turned about +y by `turn_y` degrees, then moved."""
    c, s = np.cos(np.radians(turn_y)), np.sin(np.radians(turn_y))
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    normals = None if m["normals"] is None else m["normals"] @ turn.T
    return mesh(m["positions"] * scale @ turn.T + np.asarray(offset), m["triangles"], normals, m["uvs"])


def turned(m, degrees, axis=(1, 0, 0), offset=(0, 0, 0)):
    """Turned about a line through the origin, then moved; `moved` turns about +y alone."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turn = np.eye(3) * c + cross * s + (1 - c) * np.outer((x, y, z), (x, y, z))
    normals = None if m["normals"] is None else m["normals"] @ turn.T
    return mesh(m["positions"] @ turn.T + np.asarray(offset), m["triangles"], normals, m["uvs"])


def stretched(m, factors):
    """Scaled by three factors, normals with it."""
    factors = np.asarray(factors, float)
    normals = m["normals"] / factors
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return mesh(m["positions"] * factors, m["triangles"], normals, m["uvs"])


def flipped(m):
    """Its front where its back was."""
    return dict(m, triangles=m["triangles"][:, ::-1].copy(), normals=-m["normals"])


def flat(*meshes):
    """One mesh of them all without normals and texture coordinates: flat shading, a fraction of the bytes."""
    positions, triangles, base = [], [], 0
    for m in meshes:
        unique, index = np.unique(m["positions"], axis=0, return_inverse=True)
        positions.append(unique)
        triangles.append(index.reshape(-1)[m["triangles"]] + base)
        base += len(unique)
    return mesh(np.concatenate(positions), np.concatenate(triangles))


def crinkled(m):
    """Flat shading by vertices of each triangle's own, for what has edges; `flat` saves bytes but has no uvs."""
    corners = m["positions"][m["triangles"]].astype(float)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    uvs = m["uvs"][m["triangles"]].reshape(-1, 2)
    return mesh(corners.reshape(-1, 3), np.arange(len(corners) * 3).reshape(-1, 3), np.repeat(normal, 3, 0), uvs)


def without_slivers(m, share=1e-5):
    """Without the triangles that poles and pinched ends leave next to no area, measured by their longest edges."""
    corners = m["positions"].astype(float)[m["triangles"]]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    longest = ((corners - np.roll(corners, 1, 1)) ** 2).sum(2).max(1)
    return dict(m, triangles=m["triangles"][area > share * longest])


def quad(corner, u, v, tiles=(1, 1)):
    """Front along u x v; texture coordinates with v downwards, as pictures have it, `tiles` repeats."""
    corner, u, v = (np.asarray(x, float) for x in (corner, u, v))
    uvs = np.array([[0, 1], [1, 1], [1, 0], [0, 0]]) * np.asarray(tiles)
    normal = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
    return mesh([corner, corner + u, corner + u + v, corner + v], [[0, 1, 2], [0, 2, 3]], [normal] * 4, uvs)


def box(low, high, tiles=1.0):
    """Six quads; texture coordinates in multiples of `tiles` metres."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    faces = []
    for axis in range(3):
        u, v = np.zeros(3), np.zeros(3)
        u[(axis + 1) % 3] = (high - low)[(axis + 1) % 3]
        v[(axis + 2) % 3] = (high - low)[(axis + 2) % 3]
        repeats = (np.linalg.norm(u) / tiles, np.linalg.norm(v) / tiles)
        top = low.copy()
        top[axis] = high[axis]
        faces += [quad(top, u, v, repeats), quad(low, v, u, repeats[::-1])]
    return joined(*faces)


def sphere(radius, subdivisions):
    """An icosphere with the sphere's normals."""
    golden = (1 + 5**0.5) / 2
    vertices = []
    for axis in range(3):
        for short, long in ((-1, golden), (1, golden), (-1, -golden), (1, -golden)):
            vertices.append(np.roll([short, long, 0.0], axis))
    vertices = [v / np.linalg.norm(v) for v in vertices]
    near = lambda a, b: vertices[a] @ vertices[b] > 0
    triangles = [(a, b, c) if np.linalg.det([vertices[a], vertices[b], vertices[c]]) > 0 else (a, c, b)
                 for a in range(12) for b in range(a + 1, 12) for c in range(b + 1, 12)
                 if near(a, b) and near(b, c) and near(a, c)]
    for _ in range(subdivisions):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                halfway = vertices[a] + vertices[b]
                vertices.append(halfway / np.linalg.norm(halfway))
                middles[key] = len(vertices) - 1
            return middles[key]

        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        triangles = finer
    normals = np.array(vertices)
    return mesh(normals * radius, triangles, normals)


def lathe(*profiles, segments=48):
    """Surfaces of revolution about +y. A profile is a smooth line of (radius, height); walked with the axis on its
    left side seen from the front, its front looks outward. Creases: end one profile and begin another."""
    parts = []
    angles = np.linspace(0, 2 * np.pi, segments + 1)
    for profile in profiles:
        line = np.asarray(profile, float)
        along = np.gradient(line, axis=0)
        normal = np.stack([along[:, 1], -along[:, 0]], 1)
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        c, s = np.cos(angles)[None, :, None], np.sin(angles)[None, :, None]
        spin = lambda rh: np.concatenate([rh[:, None, :1] * c, rh[:, None, 1:] + 0 * c, -rh[:, None, :1] * s], 2)
        shape = (len(line), segments + 1)
        uvs = np.stack(np.broadcast_arrays(angles[None] / (2 * np.pi), 1 - (length / length[-1])[:, None]), 2)
        index = np.arange(np.prod(shape)).reshape(shape)
        a, b, d, e = index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]
        triangles = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, e), (a, e, d))])
        positions = spin(line).reshape(-1, 3)
        corners = positions[triangles]
        area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        triangles = triangles[area > 1e-9 * area.max()]  # the axis gives triangles without area
        parts.append(mesh(positions, triangles, spin(normal).reshape(-1, 3), uvs.reshape(-1, 2)))
    return joined(*parts)


def bars(*corners):
    """Boxes given as (x0, x1, y0, y1, z0, z1)."""
    return flat(*(box(c[::2], c[1::2]) for c in corners))


def disc(radius, height, segments=16, up=True):
    """A round face that looks up, or down."""
    line = [(radius, height), (0.0, height)]
    return lathe(line if up else line[::-1], segments=segments)


def isosurface(distance, low, high, cells):
    """The zero set of `distance(points (n,3)) -> (n,)` by surface nets; normals are its gradient."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    step = (high - low).max() / cells
    counts = np.ceil((high - low) / step).astype(int)
    axes = [l + step * np.arange(n + 1) for l, n in zip(low, counts)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
    value = distance(points.reshape(-1, 3)).reshape(points.shape[:3])
    inside = value < 0

    # One vertex a cell: the mean of its edges' crossings.
    total, hits = np.zeros((*counts, 3)), np.zeros(counts)
    crossings = []
    for axis in range(3):
        head, tail = [slice(None)] * 3, [slice(None)] * 3
        head[axis], tail[axis] = slice(1, None), slice(None, -1)
        cross = inside[tuple(head)] != inside[tuple(tail)]
        a, b = value[tuple(tail)], value[tuple(head)]
        share = np.where(cross, a / np.where(cross, a - b, 1), 0)[..., None]
        at = points[tuple(tail)] + share * (points[tuple(head)] - points[tuple(tail)])
        crossings.append((cross, inside[tuple(tail)]))
        others = [k for k in range(3) if k != axis]
        for i in (0, 1):
            for j in (0, 1):
                pick = [slice(None)] * 3
                pick[others[0]] = slice(i, i + counts[others[0]])
                pick[others[1]] = slice(j, j + counts[others[1]])
                hits += cross[tuple(pick)]
                total += at[tuple(pick)] * cross[tuple(pick)][..., None]
    used = hits > 0
    index = np.full(counts, -1)
    index[used] = np.arange(used.sum())
    positions = total[used] / hits[used][:, None]

    triangles = []
    for axis, (cross, starts_inside) in enumerate(crossings):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for cell in np.argwhere(cross):
            at = lambda du, dv: index[tuple(cell - du * np.eye(3, dtype=int)[u] - dv * np.eye(3, dtype=int)[v])]
            a, b, c, d = at(1, 1), at(0, 1), at(0, 0), at(1, 0)
            loop = (a, b, c, d) if starts_inside[tuple(cell)] else (a, d, c, b)
            triangles += [(loop[0], loop[1], loop[2]), (loop[0], loop[2], loop[3])]
    small = step * 1e-2
    gradient = np.stack([distance(positions + small * e) - distance(positions - small * e) for e in np.eye(3)], 1)
    return mesh(positions, triangles, gradient / np.linalg.norm(gradient, axis=1, keepdims=True))


def curve(points, steps=4):
    """A smooth line through `points` (Catmull and Rom's), `steps` pieces between each two."""
    p = np.asarray(points, float)
    p = np.concatenate([[2 * p[0] - p[1]], p, [2 * p[-1] - p[-2]]])
    t = np.linspace(0, 1, steps, endpoint=False)[:, None]
    line = [0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3)
            for a, b, c, d in zip(p, p[1:], p[2:], p[3:])]
    return np.concatenate([*line, p[-2:-1]])


def creased(corners, segments=24):
    """A lathe's surface with a crease at every corner."""
    return lathe(*zip(corners, corners[1:]), segments=segments)


def prism(outline, low, high):
    """A convex outline of (x, z), seen from above counter-clockwise with z downwards, as high as from `low` to
    `high`; flat shading. `forms.extruded` has holes and texture coordinates."""
    outline = np.asarray(outline, float)
    n = len(outline)
    level = lambda y: np.stack([outline[:, 0], np.full(n, y), outline[:, 1]], 1)
    k = np.arange(n)
    nxt = (k + 1) % n
    sides = [np.stack(t, 1) for t in ((k, nxt, n + nxt), (k, n + nxt, n + k))]
    fan = np.stack([0 * k[1:-1], k[1:-1], k[2:]], 1)
    return mesh(np.concatenate([level(low), level(high)]), np.concatenate([*sides, fan + n, fan[:, ::-1]]))


def rounded(low, high, radius, steps=1):
    """A box with rounded edges."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    angle = np.linspace(0, np.pi / 4, steps + 1)
    side = np.tan(np.concatenate([-angle[::-1], angle]))
    sign = np.repeat([-1.0, 1.0], steps + 1)
    u, v = np.meshgrid(side, side, indexing="ij")
    direction = np.stack([np.ones_like(u), u, v], -1)
    direction /= np.linalg.norm(direction, axis=2, keepdims=True)
    signs = np.stack([np.ones_like(u), *np.meshgrid(sign, sign, indexing="ij")], -1)
    index = np.arange(u.size).reshape(u.shape)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    triangles = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    faces = []
    for axis in range(3):
        for way in (1, -1):
            mirror = np.array([way, 1.0, 1.0])
            n, s = (np.roll(x * mirror, axis, 2).reshape(-1, 3) for x in (direction, signs))
            positions = (low + high) / 2 + s * ((high - low) / 2 - radius) + radius * n
            others = [(axis + 1) % 3, (axis + 2) % 3]
            faces.append(mesh(positions, triangles[:, ::way], n, positions[:, others]))
    return joined(*faces)
