"""Surfaces from curves: sheets, sweeps, plates; the forms of `shapes.py` that stand on one axis are not enough for
cloth, branches, gears and cushions. All have normals and texture coordinates, so that `shapes.joined` takes any two."""

import numpy as np

import shapes


def sheet(points, uvs=None, tiles=1.0):
    """A smooth surface through a grid of points (rows, columns, 3); front along row x column. Texture coordinates by
    default: metres along the grid, in multiples of `tiles`."""
    p = np.asarray(points, float)
    normal = np.cross(np.gradient(p, axis=0), np.gradient(p, axis=1))
    length = np.linalg.norm(normal, axis=2, keepdims=True)
    normal = np.where(length > 1e-12, normal / np.maximum(length, 1e-12), [0, 1, 0])
    if uvs is None:
        steps = [np.linalg.norm(np.diff(p, axis=k), axis=2) for k in (0, 1)]
        v = np.pad(np.cumsum(steps[0].mean(1)), (1, 0))
        u = np.pad(np.cumsum(steps[1].mean(0)), (1, 0))
        uvs = np.stack(np.broadcast_arrays(u[None], v[:, None]), 2) / tiles
    index = np.arange(p[..., 0].size).reshape(p.shape[:2])
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    triangles = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    m = shapes.mesh(p.reshape(-1, 3), triangles, normal.reshape(-1, 3), np.reshape(uvs, (-1, 2)))
    return without_slivers(m)


def without_slivers(m, share=1e-5):
    """Without the triangles that poles and pinched ends leave next to no area, measured by their longest edges."""
    corners = m["positions"].astype(float)[m["triangles"]]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    longest = ((corners - np.roll(corners, 1, 1)) ** 2).sum(2).max(1)
    return dict(m, triangles=m["triangles"][area > share * longest])


def crinkled(m):
    """Flat shading by vertices of each triangle's own, for what has edges."""
    corners = m["positions"][m["triangles"]].astype(float)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    uvs = m["uvs"][m["triangles"]].reshape(-1, 2)
    return shapes.mesh(corners.reshape(-1, 3), np.arange(len(corners) * 3).reshape(-1, 3), np.repeat(normal, 3, 0), uvs)


def flipped(m):
    return dict(m, triangles=m["triangles"][:, ::-1].copy(), normals=-m["normals"])


def turning(axis, degrees):
    """The matrix of a right-handed turn about 'x', 'y' or 'z'."""
    k = "xyz".index(axis)
    i, j = (k + 1) % 3, (k + 2) % 3
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = np.eye(3)
    turn[i, i], turn[i, j], turn[j, i], turn[j, j] = c, -s, s, c
    return turn


def turned(m, axis, degrees, offset=(0, 0, 0)):
    turn = turning(axis, degrees)
    return shapes.mesh(m["positions"] @ turn.T + np.asarray(offset), m["triangles"], m["normals"] @ turn.T, m["uvs"])


def facing(front):
    """Three unit rows: right, up, and the direction `front`."""
    front = np.asarray(front, float) / np.linalg.norm(front)
    right = np.cross([0, 1, 0.01], front)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(front, right), front])


def stretched(m, factors):
    """Scaled by three factors, normals with it."""
    normals = m["normals"] / np.asarray(factors, float)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return shapes.mesh(m["positions"] * np.asarray(factors), m["triangles"], normals, m["uvs"])


def cushion(size, roundness=0.35, rows=10, columns=20):
    """A box whose edges are soft, standing on y = 0: upholstery, bread, pebbles. Roundness 1 is an ellipsoid."""
    power = lambda v: np.sign(v) * np.abs(v) ** roundness
    t = np.linspace(-np.pi / 2, np.pi / 2, rows + 1)[:, None]
    a = np.linspace(0, 2 * np.pi, columns + 1)[None]
    around = power(np.cos(t))
    p = np.stack(np.broadcast_arrays(around * power(np.cos(a)), power(np.sin(t)), -around * power(np.sin(a))), 2)
    m = sheet(p[:, ::-1] * np.asarray(size) / 2 + (0, size[1] / 2, 0))
    # Seam and poles have but half their neighbours: the gradient of the form itself serves all alike.
    q = p[:, ::-1].reshape(-1, 3)
    normal = np.sign(q) * np.abs(q) ** (2 / roundness - 1) / np.asarray(size)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return dict(m, normals=normal.astype(np.float32))


def swept(points, radius, segments=10, closed=False, capped=True):
    """A round tube along any points in space; `radius` is a number or one for each point."""
    p = np.asarray(points, float)
    if closed:
        p = np.concatenate([p, p[:1]])
    along = np.gradient(p, axis=0)
    if closed:
        along[0] = along[-1] = p[1] - p[-2]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    side = np.cross(along[0], np.eye(3)[np.argmin(np.abs(along[0]))])
    sides = []
    for t in along:  # carried along without twist
        side = side - t * (side @ t)
        side = side / np.linalg.norm(side)
        sides.append(side)
    sides = np.array(sides)
    if closed:  # undo what the way round has twisted
        other = np.cross(along[0], sides[0])
        twist = np.arctan2(sides[-1] @ other, sides[-1] @ sides[0]) * np.linspace(0, 1, len(p))
        sides = sides * np.cos(twist)[:, None] - np.cross(along, sides) * np.sin(twist)[:, None]
    angles = np.linspace(0, 2 * np.pi, segments + 1)[None, :, None]
    ring = np.cos(angles) * sides[:, None] + np.sin(angles) * np.cross(along, sides)[:, None]
    r = np.broadcast_to(np.asarray(radius, float), len(p))[:, None, None]
    length = np.pad(np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1)), (1, 0))
    uvs = np.stack(np.broadcast_arrays(np.linspace(0, 1, segments + 1)[None], length[:, None]), 2)
    tube = flipped(sheet(p[:, None] + r * ring, uvs))
    parts = [dict(tube, normals=ring.reshape(-1, 3).astype(np.float32))]
    for end, out in () if closed or not capped else ((0, -1), (-1, 1)):
        rim = p[end] + r[end] * ring[end]
        fan = np.stack([rim, np.broadcast_to(p[end], rim.shape)])
        cap = sheet(fan if out < 0 else fan[::-1])
        parts.append(dict(cap, normals=np.tile(out * along[end], (len(cap["positions"]), 1)).astype(np.float32)))
    return shapes.joined(*map(without_slivers, parts))


def extruded(outline, inner, depth):
    """A plate in the x-y plane between two outlines of as many points, both counter-clockwise; its front is at
    z = depth. `inner` may be one point: no hole."""
    outer = np.asarray(outline, float)
    inner = np.broadcast_to(np.asarray(inner, float), outer.shape)
    ring = lambda xy, z: np.concatenate([np.concatenate([xy, xy[:1]]), np.full((len(xy) + 1, 1), z)], 1)
    walls = [(ring(inner, depth), ring(outer, depth)), (ring(outer, 0), ring(inner, 0)),
             (ring(outer, depth), ring(outer, 0))]
    if np.ptp(inner, axis=0).max() > 0:
        walls.append((ring(inner, 0), ring(inner, depth)))
    return crinkled(shapes.joined(*(sheet(np.stack(pair)) for pair in walls)))
