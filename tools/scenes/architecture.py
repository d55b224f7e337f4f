"""Parts of buildings: walls and rooms, doors and windows, arches, vaults, columns, balusters. Walls stand in the x-y
plane; texture coordinates are metres, or multiples of `tiles` metres where a function has them."""

import numpy as np

from forms import pipe, sheet
from shapes import bars, box, curve, flat, joined, lathe, mesh, moved, quad


def solid_faces(xs, ys, holes, front, thickness):
    """The faces of a wall over the grid lines `xs` and `ys` that all edges lie on, as quads (corner, u, v): none within
    `holes` (x0, y0, x1, y1), none inside the wall, and no gaps. Its front is at z = `front`."""
    inside = lambda x, y: any(a < x < c and b < y < d for a, b, c, d in holes)
    solid = [[not inside((a + b) / 2, (c + d) / 2) for c, d in zip(ys, ys[1:])] for a, b in zip(xs, xs[1:])]
    filled = lambda i, j: 0 <= i < len(xs) - 1 and 0 <= j < len(ys) - 1 and solid[i][j]
    rear = front - thickness
    for i, (a, b) in enumerate(zip(xs, xs[1:])):
        for j, (c, d) in enumerate(zip(ys, ys[1:])):
            if not solid[i][j]:
                continue
            right, up, back, forth = (b - a, 0, 0), (0, d - c, 0), (0, 0, -thickness), (0, 0, thickness)
            yield (a, c, front), right, up
            yield (b, c, rear), (a - b, 0, 0), up
            if not filled(i - 1, j):
                yield (a, c, rear), forth, up
            if not filled(i + 1, j):
                yield (b, c, front), back, up
            if not filled(i, j - 1):
                yield (a, c, rear), right, forth
            if not filled(i, j + 1):
                yield (a, d, front), right, back


def grid_lines(holes, *ends):
    """All x and all y at which a hole or the wall itself begins or ends; `ends` are two such and two."""
    holes = np.array(holes, float).reshape(-1, 4)
    return [np.unique(np.concatenate([pair, holes[:, k::2].ravel()])) for k, pair in enumerate(ends)]


def wall(length, height, thick, openings=(), below=0.0):
    """A wall along x from 0, up from -`below`, its front at z = 0 and its back at -`thick`; `openings` are
    (left, right, bottom, top). Texture coordinates are metres, from zero again for each of its pieces."""
    # A doorway leaves no wall under the floor, in one plane with it.
    holes = [(left, bottom if bottom > 0 else -below, right, top) for left, right, bottom, top in openings]
    xs, ys = grid_lines(holes, (0, length), (-below, height))
    return joined(*(quad(corner, u, v, (np.linalg.norm(u), np.linalg.norm(v)))
                    for corner, u, v in solid_faces(xs, ys, holes, 0, thick)))


def pierced_wall(width, height, thickness, holes, tiles=1.0):
    """A wall along x from 0, up from 0, its middle at z = 0, with rectangular holes (x0, y0, x1, y1). Its texture
    goes on from piece to piece."""
    parts = []
    for corner, u, v in solid_faces(*grid_lines(holes, (0, width), (0, height)), holes, thickness / 2, thickness):
        q = quad(corner, u, v)
        axis = np.argmax(np.abs(q["normals"][0]))
        pick = ([2, 1], [0, 2], [0, 1])[axis]
        q["uvs"] = (q["positions"][:, pick] * (1, -1) / tiles).astype(np.float32)
        parts.append(q)
    return joined(*parts)


def room(x0, x1, z0, z1, height, thick=0.12, **openings):
    """Walls around, fronts inside, floor and ceiling apart. `openings` by side: (low, high, bottom, top) each, in x or
    in z; a side that is None is left out. The walls go past the corners and beyond floor and ceiling, so that no
    light leaks."""
    across, along, above = x1 - x0 + 2 * thick, z1 - z0 + 2 * thick, height + 0.08
    sides = dict(  # length, the place of the wall's own x = 0, its turn, and how x or z becomes its own x
        back=(across, (x0 - thick, 0, z0), 0, lambda a, b: (a - x0 + thick, b - x0 + thick)),
        front=(across, (x1 + thick, 0, z1), 180, lambda a, b: (x1 + thick - b, x1 + thick - a)),
        left=(along, (x0, 0, z1 + thick), 90, lambda a, b: (z1 + thick - b, z1 + thick - a)),
        right=(along, (x1, 0, z0 - thick), -90, lambda a, b: (a - z0 + thick, b - z0 + thick)))
    piece = {}
    for side, (length, at, turn, own) in sides.items():
        holes = openings.get(side, ())
        if holes is not None:
            holes = [(*own(a, b), low, high) for a, b, low, high in holes]
            piece[side] = moved(wall(length, above, thick, holes, below=0.08), at, turn)
    return piece


def door_leaf(width=0.86, height=2.03, thick=0.04):
    """A door with four sunk panels, from its hinge at the origin along +x; both its sides are alike."""
    frame, sunk, middle, half = 0.12, 0.012, 0.95, thick / 2
    columns, rows = (0, frame, width / 2 - 0.05, width / 2 + 0.05, width - frame, width), (0, 0.2, middle, 1.08)
    rows = (*rows, height - frame, height)
    parts = [(columns[i], columns[i + 1], 0, height, -half, half) for i in (0, 2, 4)]
    for i in (1, 3):
        parts += [(columns[i], columns[i + 1], rows[j], rows[j + 1], -half, half) for j in (0, 2, 4)]
        for j in (1, 3):
            parts.append((columns[i], columns[i + 1], rows[j], rows[j + 1], sunk - half, half - sunk))
            edge = 0.05
            parts.append((columns[i] + edge, columns[i + 1] - edge, rows[j] + edge, rows[j + 1] - edge, -half + 0.004,
                          half - 0.004))
    handle = []
    for side in (1, -1):
        out = half + 0.05
        lever = [(width - 0.06, 1.02, side * half), (width - 0.06, 1.02, side * (out - 0.01)),
                 (width - 0.075, 1.02, side * out), (width - 0.17, 1.015, side * out)]
        handle.append(pipe(curve(lever, 3), 0.009))
        plate = (width - 0.085, width - 0.035, 0.92, 1.1, side * half, side * (half + 0.006))
        handle.append(box(np.minimum(plate[::2], plate[1::2]), np.maximum(plate[::2], plate[1::2])))
    return dict(door=bars(*parts), metal=flat(*handle))


def door_frame(width=0.88, height=2.05, depth=0.12, casing=0.09):
    """The lining and casings of an opening from x = 0 in a wall whose front is z = 0."""
    lining, proud, back = 0.02, 0.018, -depth
    parts = [(-0.001, lining, 0, height - lining, back, 0),
             (width - lining, width + 0.001, 0, height - lining, back, 0),
             (-0.001, width + 0.001, height - lining, height + 0.001, back, 0)]
    for front, rear in ((proud, 0.0), (back, back - proud)):
        parts += [(-casing, 0.008, 0, height + casing, rear, front),
                  (width - 0.008, width + casing, 0, height + casing, rear, front),
                  (0.008, width - 0.008, height - 0.008, height + casing, rear, front)]
    return dict(frame=bars(*parts))


def window_frame(width, height, depth=0.12, bar=0.05, columns=2, rows=2):
    """Lining, sashes and bars of an opening from the origin in a wall whose front is z = 0, without panes."""
    parts = [(0, bar, 0, height, -depth, -0.02), (width - bar, width, 0, height, -depth, -0.02),
             (bar, width - bar, 0, bar, -depth, -0.02), (bar, width - bar, height - bar, height, -depth, -0.02)]
    for i in range(1, columns):
        x = width * i / columns
        parts.append((x - bar / 2, x + bar / 2, bar, height - bar, -0.8 * depth, -0.4 * depth))
    for j in range(1, rows):
        y = height * j / rows
        parts.append((bar, width - bar, y - bar / 4, y + bar / 4, -0.75 * depth, -0.45 * depth))
    return dict(frame=bars(*parts))


def skirting(length, height=0.09, openings=()):
    """A board along the foot of a wall along +x, front at +z; `openings` are (left, right)."""
    ends = [0, *(x for pair in sorted(openings) for x in pair), length]
    return bars(*((a, b, 0, height, -0.005, 0.015) for a, b in zip(ends[::2], ends[1::2]) if b > a))


def wainscot(length, height=0.95, openings=(), every=0.62):
    """Panelling along the foot of a wall along +x: boards, sunk panels by their frames, a rail on top."""
    ends = [0, *(x for pair in sorted(openings) for x in pair), length]
    parts = []
    for a, b in zip(ends[::2], ends[1::2]):
        if b - a < 0.02:
            continue
        parts += [(a, b, 0, height, -0.005, 0.012), (a, b, 0, 0.14, 0.012, 0.026),
                  (a, b, height - 0.09, height, 0.012, 0.02),
                  (a, b, height, height + 0.025, -0.005, 0.04)]
        edges = np.linspace(a, b, max(1, round((b - a) / every)) + 1)
        parts += [(max(a, x - 0.045), min(b, x + 0.045), 0.14, height - 0.09, 0.012, 0.02) for x in edges]
        parts += [(x + 0.09, y - 0.09, 0.21, height - 0.15, 0.012, 0.017)
                  for x, y in zip(edges, edges[1:]) if y - x > 0.25]
    return bars(*parts)


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
    feet = [quad((x, springing, -half), (foot, 0, 0), (0, 0, thickness), (foot / tiles, thickness / tiles))
            for x in (-width / 2, radius)]
    return joined(face, mirrored(face), soffit, *feet)


def mirrored(m):
    """The same, behind: turned half round about +y."""
    turn = (-1, 1, -1)
    return mesh(m["positions"] * turn, m["triangles"], m["normals"] * turn, m["uvs"])


def archivolt(radius, springing, width, depth, segments=20):
    """A raised band around an arch, its back at z = 0."""
    a = np.linspace(0, np.pi, segments + 1)
    arc = lambda r, z: np.stack([r * np.cos(a), springing + r * np.sin(a), np.full_like(a, z)], 1)
    inner, outer = radius - 0.004, radius + width
    lines = [arc(inner, 0), arc(inner, depth), arc((inner + outer) / 2, depth * 1.35), arc(outer, depth), arc(outer, 0)]
    return joined(*(sheet(np.stack(pair)) for pair in zip(lines, lines[1:])))


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
        webs.append(moved(dict(web, normals=normals.astype(np.float32)), turn_y=90 * turn))
    return joined(*webs)


def frame(inner, outer, low, high, tiles=1.0):
    """A rectangular ring around the y axis from half extents `inner` to `outer` (x, z), of four boxes."""
    (a, b), (c, d) = inner, outer
    return joined(*(box((x0, low, z0), (x1, high, z1), tiles) for x0, z0, x1, z1 in (
        (-c, -d, c, -b), (-c, b, c, d), (-c, -b, -a, b), (a, -b, c, b))))


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
    square = lambda half, low, high: box((-half, low, -half), (half, high, half))
    return joined(square(1.45 * r, 0, plinth), lathe(base, shaft, bell, segments=segments),
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
            parts.append(moved(leaf, turn_y=360 / leaves * (k + 0.5 * row)))
    return joined(*parts)


def baluster(height, radius, segments=8):
    profile = [(0.6, 0.0), (0.6, 0.08), (0.45, 0.12), (0.8, 0.25), (1.0, 0.38), (0.8, 0.52), (0.42, 0.72),
               (0.4, 0.86), (0.6, 0.92), (0.6, 1.0)]
    return lathe([(r * radius, y * height) for r, y in profile], segments=segments)


def steps_of(profile, length):
    """A cornice: boxes (low y, high y, reach) stacked, sticking out towards +z from a wall at z = 0."""
    boxes = [box((-length / 2, low, -0.05), (length / 2, high, reach)) for low, high, reach in profile]
    return joined(*boxes)
