"""Surfaces from curves: sheets, tubes, plates, for what the forms of `shapes.py` that stand on one axis are not enough.
All but `tube` and `pipe` have texture coordinates, so that `shapes.joined` takes any two."""

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
    return shapes.without_slivers(m)


def surface(point, across, down, tiles=(1, 1)):
    """The sheet `point(s, t)` over the unit square, t downwards like a picture's; front along d/dt x d/ds."""
    s, t = np.meshgrid(np.linspace(0, 1, across + 1), np.linspace(0, 1, down + 1))
    return sheet(np.stack(np.broadcast_arrays(*point(s, t)), -1), np.stack([s, t], -1) * np.asarray(tiles))


def facing(front):
    """Three unit rows: right, up, and the direction `front`."""
    front = np.asarray(front, float) / np.linalg.norm(front)
    right = np.cross([0, 1, 0.01], front)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(front, right), front])


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


def carried(along):
    """For each direction of a line a unit vector across it, carried along with as little twist as can be."""
    side = np.cross(along[0], np.eye(3)[np.argmin(np.abs(along[0]))])
    sides = []
    for t in along:
        side = side - t * (side @ t)
        side = side / np.linalg.norm(side)
        sides.append(side)
    return np.array(sides)


def ringed(centers, radius, rings):
    """An open tube of rings of unit vectors, one about each centre; without texture coordinates and so without a
    seam."""
    positions = centers[:, None] + radius * rings
    index = np.arange(positions.size // 3).reshape(positions.shape[:2])
    a, b, d, e = index[:-1], np.roll(index, -1, 1)[:-1], index[1:], np.roll(index, -1, 1)[1:]
    triangles = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, e), (a, e, d))])
    return shapes.mesh(positions.reshape(-1, 3), triangles, rings.reshape(-1, 3))


def tube(points, radius, segments=12):
    """A round tube along `points` in a plane of constant z, open at its ends."""
    points = np.asarray(points, float)
    along = np.gradient(points, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    side = np.stack([-along[:, 1], along[:, 0], 0 * along[:, 0]], 1)
    angles = np.linspace(0, 2 * np.pi, segments, endpoint=False)
    ring = np.cos(angles)[None, :, None] * side[:, None] + np.sin(angles)[None, :, None] * np.array([0, 0, 1.0])
    return ringed(points, radius, ring)


def pipe(points, radius, segments=8):
    """A round tube along any line, closed at its ends; `radius` may be one for each point. Fewer vertices than
    `swept`, and no texture coordinates."""
    points = np.asarray(points, float)
    radius = np.broadcast_to(np.asarray(radius, float), len(points))
    along = np.gradient(points, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    angles = np.linspace(0, 2 * np.pi, segments, endpoint=False)[None, :, None]
    sides = carried(along)[:, None]
    rings = np.cos(angles) * sides + np.sin(angles) * np.cross(along[:, None], sides)
    body = ringed(points, radius[:, None, None], rings)
    fan = np.stack([np.zeros(segments - 2, int), np.arange(1, segments - 1), np.arange(2, segments)], 1)
    ends = body["positions"].reshape(len(points), segments, 3)
    caps = [shapes.mesh(ends[end], fan[:, ::way], [way * along[end]] * segments) for end, way in ((0, -1), (-1, 1))]
    return shapes.joined(body, *caps)


def swept(points, radius, segments=10, closed=False, capped=True):
    """A round tube along any line, also a closed one, with texture coordinates; `radius` may be one for each point."""
    p = np.asarray(points, float)
    if closed:
        p = np.concatenate([p, p[:1]])
    along = np.gradient(p, axis=0)
    if closed:
        along[0] = along[-1] = p[1] - p[-2]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    sides = carried(along)
    if closed:  # undo what the way round has twisted
        other = np.cross(along[0], sides[0])
        twist = np.arctan2(sides[-1] @ other, sides[-1] @ sides[0]) * np.linspace(0, 1, len(p))
        sides = sides * np.cos(twist)[:, None] - np.cross(along, sides) * np.sin(twist)[:, None]
    angles = np.linspace(0, 2 * np.pi, segments + 1)[None, :, None]
    ring = np.cos(angles) * sides[:, None] + np.sin(angles) * np.cross(along, sides)[:, None]
    r = np.broadcast_to(np.asarray(radius, float), len(p))[:, None, None]
    length = np.pad(np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1)), (1, 0))
    uvs = np.stack(np.broadcast_arrays(np.linspace(0, 1, segments + 1)[None], length[:, None]), 2)
    body = shapes.flipped(sheet(p[:, None] + r * ring, uvs))
    parts = [dict(body, normals=ring.reshape(-1, 3).astype(np.float32))]
    for end, out in () if closed or not capped else ((0, -1), (-1, 1)):
        rim = p[end] + r[end] * ring[end]
        fan = np.stack([rim, np.broadcast_to(p[end], rim.shape)])
        cap = sheet(fan if out < 0 else fan[::-1])
        parts.append(dict(cap, normals=np.tile(out * along[end], (len(cap["positions"]), 1)).astype(np.float32)))
    return shapes.joined(*map(shapes.without_slivers, parts))


def extruded(outline, inner, depth):
    """A plate in the x-y plane between two outlines of as many points, both counter-clockwise; its front is at
    z = depth. `inner` may be one point: no hole. For plain convex ones `shapes.prism` does with fewer vertices."""
    outer = np.asarray(outline, float)
    inner = np.broadcast_to(np.asarray(inner, float), outer.shape)
    ring = lambda xy, z: np.concatenate([np.concatenate([xy, xy[:1]]), np.full((len(xy) + 1, 1), z)], 1)
    walls = [(ring(inner, depth), ring(outer, depth)), (ring(outer, 0), ring(inner, 0)),
             (ring(outer, depth), ring(outer, 0))]
    if np.ptp(inner, axis=0).max() > 0:
        walls.append((ring(inner, 0), ring(inner, depth)))
    return shapes.crinkled(shapes.joined(*(sheet(np.stack(pair)) for pair in walls)))
