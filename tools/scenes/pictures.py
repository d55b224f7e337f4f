"""Textures for our scenes, as (height, width, 3) arrays in [0, 1], sRGB unless stated otherwise."""

import struct
import zlib

import numpy as np


def png(picture):
    """The bytes of an 8-bit PNG, RGB or RGBA."""
    pixels = (np.clip(picture, 0, 1) * 255 + 0.5).astype(np.uint8)
    height, width, channels = pixels.shape
    rows = np.concatenate([np.zeros((height, 1), np.uint8), pixels.reshape(height, -1)], 1)
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", width, height, 8, {3: 2, 4: 6}[channels], 0, 0, 0)
    body = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows.tobytes(), 9)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + body


def plane(width, height):
    """Pixel centres as x, y in [0, 1), y downwards."""
    y, x = np.mgrid[0:height, 0:width]
    return (x + 0.5) / width, (y + 0.5) / height


def blend(a, b, share):
    return np.asarray(a) * (1 - share[..., None]) + np.asarray(b) * share[..., None]


def smooth(edge, value, width):
    """0 below `edge`, 1 above, a ramp of `width` between."""
    return np.clip((value - edge) / width + 0.5, 0, 1)


def noise(width, height, cells, seed):
    """Smooth value noise that repeats at the borders, in [0, 1]; `cells` across and down."""
    rng = np.random.default_rng(seed)
    grid = rng.random((cells[1], cells[0]))
    x, y = plane(width, height)
    x, y = x * cells[0], y * cells[1]
    i, j = x.astype(int), y.astype(int)
    fade = lambda t: t * t * (3 - 2 * t)
    s, t = fade(x - i), fade(y - j)
    at = lambda di, dj: grid[(j + dj) % cells[1], (i + di) % cells[0]]
    top, bottom = at(0, 0) * (1 - s) + at(1, 0) * s, at(0, 1) * (1 - s) + at(1, 1) * s
    return top * (1 - t) + bottom * t


def gingham(size=192):
    """A checkered cloth, one repeat: white, half and full stripes, with a hint of its threads."""
    x, y = plane(size, size)
    share = ((x < 0.5).astype(float) + (y < 0.5)) / 2
    cloth = blend([0.93, 0.91, 0.87], [0.72, 0.1, 0.11], share)
    threads = 0.04 * (np.sin(x * size * np.pi / 2) * np.sin(y * size * np.pi / 2))
    return cloth + threads[..., None]


def wood(width, height, light, dark, seed):
    """Grain along x that repeats."""
    slow = noise(width, height, (2, 6), seed)
    x, y = plane(width, height)
    rings = 0.5 + 0.5 * np.sin(2 * np.pi * (9 * y + 2.2 * slow))
    fibre = noise(width, height, (6, height // 3), seed + 1)
    return blend(light, dark, np.clip(0.55 * rings**2 + 0.45 * fibre, 0, 1))


def plaster(size=192):
    """A tangent-space normal map (linear) of a wall painted with a brush."""
    height = 0.6 * noise(size, size, (24, 24), 3) + 0.4 * noise(size, size, (60, 60), 4)
    slope = lambda axis: (np.roll(height, -1, axis) - np.roll(height, 1, axis)) * 0.9
    normal = np.stack([-slope(1), slope(0), np.ones_like(height)], 2)
    return normal / np.linalg.norm(normal, axis=2, keepdims=True) * 0.5 + 0.5


def dusk(width=320, height=240):
    """What the window shows: evening sky, a moon, hills."""
    x, y = plane(width, height)
    sky = blend([0.15, 0.22, 0.42], [0.47, 0.5, 0.66], smooth(0.3, y, 0.6))
    sky = blend(sky, [0.98, 0.66, 0.42], smooth(0.63, y, 0.4) ** 2)
    moon = np.hypot((x - 0.3) * width / height, y - 0.27)
    dark_side = np.hypot((x - 0.325) * width / height, y - 0.255)
    sky = blend(sky, [1.0, 0.97, 0.86], (1 - smooth(0.05, moon, 0.008)) * smooth(0.047, dark_side, 0.008))
    far = 0.74 + 0.05 * np.sin(x * 7 + 1) + 0.02 * np.sin(x * 19)
    near = 0.86 + 0.05 * np.sin(x * 5 + 4) + 0.015 * np.sin(x * 23)
    sky = blend(sky, [0.34, 0.33, 0.47], smooth(0, y - far, 0.01))
    return blend(sky, [0.13, 0.17, 0.22], smooth(0, y - near, 0.01))


def shade(width=96, height=64):
    """A lamp shade's cloth from inside lit: brightest in the middle, fine ribs."""
    x, y = plane(width, height)
    ribs = 0.94 + 0.06 * np.cos(x * 2 * np.pi * 24)
    glow = (0.72 + 0.28 * np.sin(np.pi * y)) * ribs
    return np.array([1.0, 0.83, 0.58]) * glow[..., None]


def stripes(width=8, height=128):
    """A cup's glaze along its profile: cream with two blue rings."""
    _, y = plane(width, height)
    ring = lambda at, half: 1 - smooth(half, np.abs(y - at), 0.01)
    return blend([0.93, 0.92, 0.88], [0.12, 0.25, 0.55], np.clip(ring(0.12, 0.035) + ring(0.22, 0.012), 0, 1))


def poster(width=180, height=240):
    """A print: from the eye and from the lamp, two paths that meet halfway."""
    x, y = plane(width, height)
    x = x * width / height
    picture = blend([0.93, 0.9, 0.82], [0.93, 0.9, 0.82], x)

    def line(picture, a, b, half, colour):
        a, b = np.array(a), np.array(b)
        share = np.clip(((x - a[0]) * (b - a)[0] + (y - a[1]) * (b - a)[1]) / ((b - a) @ (b - a)), 0, 1)
        gap = np.hypot(x - a[0] - share * (b - a)[0], y - a[1] - share * (b - a)[1])
        return blend(picture, colour, 1 - smooth(half, gap, 0.006))

    disc = lambda picture, at, radius, colour: blend(
        picture, colour, 1 - smooth(radius, np.hypot(x - at[0], y - at[1]), 0.006))
    ink, sun, blue = [0.16, 0.17, 0.22], [0.93, 0.58, 0.16], [0.16, 0.38, 0.58]
    picture = disc(picture, (0.56, 0.2), 0.105, sun)
    for a, b in (((0.56, 0.2), (0.64, 0.6)), ((0.64, 0.6), (0.4, 0.5))):
        picture = line(picture, a, b, 0.009, sun)
    for a, b in (((0.16, 0.78), (0.24, 0.36)), ((0.24, 0.36), (0.4, 0.5))):
        picture = line(picture, a, b, 0.009, blue)
    picture = disc(picture, (0.4, 0.5), 0.034, [0.78, 0.16, 0.15])
    lens = np.maximum(np.hypot(x - 0.16, y - 0.9), np.hypot(x - 0.16, y - 0.66))
    picture = blend(picture, ink, 1 - smooth(0.158, lens, 0.006))
    picture = blend(picture, [0.96, 0.95, 0.9], 1 - smooth(0.146, lens, 0.006))
    picture = disc(picture, (0.16, 0.78), 0.026, blue)
    return disc(picture, (0.16, 0.78), 0.011, ink)


def few(picture, levels=40):
    """Fewer colours, for a smaller file."""
    return np.round(np.asarray(picture) * levels) / levels


def boards(size, across, light, dark, seed):
    """A wooden floor, one repeat: `across` boards along x, their ends staggered, dark joints between them; in few
    colours, where `planks` have more grain and no ends."""
    x, y = plane(size, size)
    row = (y * across).astype(int)
    rng = np.random.default_rng(seed)
    start, tone = rng.random(across)[row], rng.random((across, 2))
    along = (x + start) % 1
    tone = np.where(along < 0.5, tone[row, 0], tone[row, 1])
    grain = noise(size, size, (4, size // 5), seed + 1)
    share = np.clip(0.7 * tone + 0.3 * grain, 0, 1)
    joint = np.minimum(np.minimum(along, np.abs(along - 0.5)), 1 - along) < 0.8 / size
    joint |= np.abs(y * across - row - 0.5) > 0.5 - 0.7 * across / size
    return few(np.where(joint[..., None], np.asarray(dark) * 0.45, blend(light, dark, share)))


def tiles(size, count, colours, grout, seed, joint=0.035):
    """`count` x `count` tiles, each in one of `colours` or between two."""
    x, y = plane(size, size)
    x, y = x * count, y * count
    rng = np.random.default_rng(seed)
    colours = np.asarray(colours, float)
    pick = rng.integers(0, len(colours), (count, count))
    tone = 1 + 0.05 * rng.standard_normal((count, count, 1))
    i, j = x.astype(int), y.astype(int)
    edge = np.maximum(np.abs(x - i - 0.5), np.abs(y - j - 0.5))
    return few(blend((colours[pick] * tone)[j, i], grout, smooth(0.5 - joint / 2, edge, 1.5 * count / size)), 80)


def checkers(size, count, light, dark, grout):
    """Floor tiles in two colours by turns."""
    x, y = plane(size, size)
    x, y = x * count, y * count
    i, j = x.astype(int), y.astype(int)
    edge = np.maximum(np.abs(x - i - 0.5), np.abs(y - j - 0.5))
    colour = blend(light, dark, ((i + j) % 2).astype(float))
    colour *= (0.95 + 0.1 * noise(size, size, (8, 8), 5))[..., None]
    return few(blend(colour, grout, smooth(0.49, edge, 1.5 * count / size)), 60)


def carpet(width, height, ground, figure, accent, cells=7):
    """A woven rug: rows of lozenges in a double border; its knots show."""
    x, y = plane(width, height)
    ratio = width / height
    edge = np.minimum(np.minimum(x, 1 - x) * ratio, np.minimum(y, 1 - y))
    u, v = (x * cells * ratio) % 1 - 0.5, (y * cells) % 1 - 0.5
    lozenge = np.abs(u) + np.abs(v)
    picture = blend(ground, figure, (lozenge < 0.42).astype(float))
    picture = blend(picture, accent, (lozenge < 0.24).astype(float))
    picture = blend(picture, ground, (lozenge < 0.1).astype(float))
    border = (edge < 0.1) & (edge > 0.015)
    zigzag = np.abs(((x * ratio + y) * 14) % 1 - 0.5) + np.abs(((x * ratio - y) * 14) % 1 - 0.5)
    picture = np.where(border[..., None], blend(figure, accent, (zigzag < 0.4).astype(float)), picture)
    rim = (np.abs(edge - 0.1) < 0.006) | (edge < 0.015)
    picture = np.where(rim[..., None], np.asarray(accent), picture)
    knots = 1 - 0.08 * ((np.arange(height)[:, None] + np.arange(width)[None]) % 2)
    return few(picture * knots[..., None], 60)


def landscape(width, height, seed, sky=((0.55, 0.68, 0.85), (0.95, 0.86, 0.7)), land=(0.2, 0.32, 0.2)):
    """A painted view: a sky, a sun, ranges of hills that grow darker towards the front."""
    rng = np.random.default_rng(seed)
    x, y = plane(width, height)
    picture = blend(*sky, smooth(0.3, y, 0.7))
    at = rng.uniform(0.2, 0.8)
    disc = np.hypot((x - at) * width / height, y - 0.24)
    picture = blend(picture, [1, 0.93, 0.78], 1 - smooth(0.07, disc, 0.02))
    for layer in range(4):
        share = (layer + 1) / 4
        a, b, c = rng.uniform(0, 6, 3)
        line = 0.42 + 0.13 * layer + 0.07 * np.sin(x * 4 + a) + 0.03 * np.sin(x * 11 + b) + 0.01 * np.sin(x * 29 + c)
        hill = np.asarray(sky[1]) * 0.8 * (1 - share) + np.asarray(land) * share
        picture = blend(picture, hill, smooth(0, y - line, 0.012))
    brush = noise(width, height, (width // 6, height // 3), seed + 3)
    return few(picture * (0.93 + 0.1 * brush)[..., None], 60)


def abstract(width, height, seed, colours, ground=(0.92, 0.89, 0.82)):
    """A print of overlapping discs and bars."""
    rng = np.random.default_rng(seed)
    x, y = plane(width, height)
    x = x * width / height
    picture = blend(ground, ground, x)
    for colour in colours:
        at, radius = rng.uniform(0.2, 0.8, 2) * (width / height, 1), rng.uniform(0.1, 0.28)
        if rng.random() < 0.6:
            shape = np.hypot(x - at[0], y - at[1]) - radius
        else:
            shape = np.maximum(np.abs(x - at[0]) - radius * 1.3, np.abs(y - at[1]) - radius * 0.3)
        picture = blend(picture, colour, 0.9 * (1 - smooth(0, shape, 0.012)))
    return few(picture, 60)


def botanical(width, height, seed, ink=(0.16, 0.3, 0.2)):
    """A twig with its leaves, as in an old flora."""
    rng = np.random.default_rng(seed)
    x, y = plane(width, height)
    x = (x - 0.5) * width / height
    picture = blend([0.93, 0.9, 0.8], [0.9, 0.86, 0.74], noise(width, height, (3, 4), seed))
    stem = 0.05 * np.sin(y * 5 + rng.uniform(0, 6))
    picture = blend(picture, ink, (1 - smooth(0.006, np.abs(x - stem), 0.008)) * ((y > 0.14) & (y < 0.9)))
    for i, level in enumerate(np.linspace(0.18, 0.72, 8)):
        way, length = (-1) ** i, 0.2 + 0.06 * rng.random()
        angle = np.radians(rng.uniform(25, 45))
        u = way * (x - 0.05 * np.sin(level * 5)) * np.cos(angle) - (y - level) * np.sin(angle)
        v = way * (x - 0.05 * np.sin(level * 5)) * np.sin(angle) + (y - level) * np.cos(angle)
        leaf = np.abs(v) - 0.22 * length * np.sqrt(np.clip(u / length * (1 - u / length) * 4, 0, 1))
        inside = (u > 0) & (u < length)
        tone = np.asarray(ink) * (0.9 + 0.5 * rng.random())
        picture = blend(picture, tone, (1 - smooth(0, leaf, 0.01)) * inside)
    return few(picture, 60)


def wallpaper(size, ground, figure):
    """Stripes, and between them sprigs that step from row to row."""
    x, y = plane(size, size)
    stripe = (np.abs(x * 4 % 1 - 0.5) < 0.06).astype(float)
    u, v = x * 4 % 1, (y * 4 + 0.5 * ((x * 4).astype(int) % 2)) % 1
    petal = np.hypot(np.abs(u - np.round(u)) - 0.07, (v - 0.5) * 0.6) < 0.07
    return few(blend(ground, figure, np.clip(stripe + 0.8 * petal, 0, 1)))


def runner(width, height, ground, stripe):
    """A table runner's cloth: stripes along its sides, darned with small crosses."""
    x, y = plane(width, height)
    edge = np.minimum(y, 1 - y)
    lines = ((np.abs(edge - 0.12) < 0.03) | (np.abs(edge - 0.22) < 0.012)).astype(float)
    u, v = np.abs(x * 24 % 1 - 0.5), np.abs((y - 0.5) * height / width * 24)
    cross = (np.minimum(u, v) < 0.1) & (np.maximum(u, v) < 0.3)
    threads = 1 - 0.05 * ((np.arange(height)[:, None] + np.arange(width)[None]) % 2)
    return few(blend(ground, stripe, np.clip(lines + cross, 0, 1)) * threads[..., None], 60)


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
    """Boards along x with grain, without ends, dark between them."""
    grain = wood(size, size, light, dark, seed)
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


def spray(size=128, leaves=26, seed=1):
    """A spray of leaves with its outline as alpha, (size, size, 4)."""
    rng = np.random.default_rng(seed)
    x, y = plane(size, size)
    x, y = 2 * x - 1, 1 - 2 * y
    color = np.broadcast_to([0.2, 0.32, 0.1], (size, size, 3))
    alpha = 1 - smooth(0.016, np.abs(x - 0.08 * np.sin(3 * y)), 0.012)
    alpha = alpha * (np.abs(y) < 0.85)
    for k in range(leaves):
        root = -0.8 + 1.5 * k / leaves
        a = np.radians(90 + (-1) ** k * rng.uniform(25, 75))
        long, wide = rng.uniform(0.3, 0.5) * (1 - 0.25 * abs(root)), rng.uniform(0.085, 0.13)
        dx, dy = x - 0.08 * np.sin(3 * root), y - root
        along, across = (dx * np.cos(a) + dy * np.sin(a)) / long, (dy * np.cos(a) - dx * np.sin(a)) / wide
        half = np.sqrt(np.clip(along * (1 - along), 0, 1)) * 1.6 * (1 - 0.5 * along)
        inside = 1 - smooth(0, np.abs(across) - half, 0.12)
        inside = inside * ((along > 0) & (along < 1))
        shade = blend([0.2, 0.36, 0.1], [0.42, 0.56, 0.16], np.full_like(x, rng.random()))
        vein = 1 - 0.25 * (1 - smooth(0.05, np.abs(across), 0.05))
        color = blend(color, shade * vein[..., None], inside)
        alpha = np.maximum(alpha, inside)
    return np.concatenate([color, alpha[..., None]], 2)


def lawn(light, dark, size=256, seed=4):
    """Mown lawn from above: fine streaks in soft patches."""
    fine = noise(size, size, (size // 2, size // 6), seed)
    patch = noise(size, size, (6, 6), seed + 1)
    return blend(light, dark, np.clip(0.6 * fine + 0.4 * patch, 0, 1))
