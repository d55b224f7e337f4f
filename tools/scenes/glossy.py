#!/usr/bin/env python3
"""Makes scenes/glossy.glb: a still life of polished metal in a dim studio, whose lamps shine at metal sheets, not at
the table. Nearly every light path goes by two or more narrow lobes, so that a connection between given vertices is
worth next to nothing: the failure case of methods that connect.

    python3 tools/scenes/glossy.py [OUT.glb]
"""

import numpy as np

import scene
import shapes
from forms import cushion, extruded, facing, sheet, swept
from looks import lit, matte, printed
from pictures import cloudy


def metals(glb):
    metal = lambda name, color, roughness: glb.material(name, color, metallic=1.0, roughness=roughness)
    return dict(
        steel=metal("steel", (0.6, 0.61, 0.63), 0.06), chrome=metal("chrome", (0.68, 0.69, 0.7), 0.03),
        silver=metal("silver", (0.93, 0.91, 0.87), 0.08), gold=metal("gold", (1.0, 0.75, 0.33), 0.1),
        copper=metal("copper", (0.94, 0.61, 0.5), 0.09), brass=metal("brass", (0.88, 0.72, 0.38), 0.11),
        bronze=metal("bronze", (0.66, 0.45, 0.26), 0.12), dark=metal("gunmetal", (0.66, 0.67, 0.7), 0.12),
        sheet=metal("sheet metal", (0.72, 0.73, 0.75), 0.12), tray=metal("brushed tray", (0.8, 0.8, 0.78), 0.12))


def gear(teeth, radius, hole, depth):
    """A spur gear lying flat, its underside on y = 0."""
    tooth = 2 * np.pi / teeth
    corners = np.array([(0.0, 0.9), (0.22, 0.9), (0.34, 1.06), (0.6, 1.06), (0.72, 0.9)])
    angle = (np.arange(teeth)[:, None] + corners[:, 0]) * tooth
    reach = np.tile(corners[:, 1], (teeth, 1)) * radius
    outline = np.stack([reach * np.cos(angle), reach * np.sin(angle)], 2).reshape(-1, 2)
    round_hole = hole * np.stack([np.cos(angle), np.sin(angle)], 2).reshape(-1, 2)
    hub = shapes.lathe([(1.9 * hole, depth), (1.9 * hole, 1.5 * depth)],
                       [(1.9 * hole, 1.5 * depth), (hole, 1.5 * depth)],
                       [(hole, 1.5 * depth), (hole, depth)])
    return shapes.joined(shapes.turned(extruded(outline, round_hole, depth), -90), hub)


def spoon(length=0.17):
    """Bowl to +x, lying on the table."""
    t = np.linspace(0, 1, 24)
    handle = np.stack([-length * t, 0.012 + 0.012 * np.sin(np.pi * t) - 0.008 * t**2, 0 * t], 1)
    stem = swept(handle, 0.0026 + 0.0022 * t**3, 10)
    stem = shapes.stretched(stem, (1, 1, 1.6))
    a = np.linspace(0.02, np.pi / 2, 10)
    outside = np.stack([np.sin(a), -np.cos(a)], 1)
    inside = (outside * 0.93)[::-1]
    bowl = shapes.lathe(outside, [outside[-1], inside[0]], inside, segments=32)
    return shapes.joined(stem, shapes.moved(shapes.stretched(bowl, (0.033, 0.013, 0.022)), (0.03, 0.0135, 0)))


def fork(length=0.13):
    t = np.linspace(0, 1, 24)
    stem = shapes.stretched(swept(np.stack([-length * t, 0.008 + 0.012 * np.sin(np.pi * t), 0 * t], 1), 0.0028, 10),
                            (1, 1, 1.7))
    root = shapes.moved(cushion((0.03, 0.005, 0.026), 0.6), (0.01, 0.0055, 0))
    t = t[:12] / t[11]
    prongs = [swept(np.stack([0.015 + 0.045 * t, 0.008 - 0.004 * np.sin(np.pi * t), 0 * t + z], 1),
                    0.0021 - 0.001 * t**4, 8)
              for z in (-0.0096, -0.0032, 0.0032, 0.0096)]
    return shapes.joined(stem, root, *prongs)


def knife():
    t = np.linspace(0, 1, 16)
    upper = np.stack([0.11 * t, 0.009 * np.sqrt(np.clip(1 - t**6, 0, 1))], 1)
    lower = np.stack([0.11 * t, -0.009 + 0.006 * t**4], 1)[:-1]
    outline = np.concatenate([lower, upper[::-1]])
    blade = shapes.moved(shapes.turned(extruded(outline, (0.05, 0), 0.0016), -90), (0, 0.004, 0))
    return shapes.joined(blade, shapes.moved(cushion((0.1, 0.009, 0.019), 0.55), (-0.047, 0.0, 0)))


def tray():
    """A rounded oblong with a raised rim."""
    a = np.linspace(0, 2 * np.pi, 97)
    power = lambda v: np.sign(v) * np.abs(v) ** 0.35
    round_ = np.stack([0.25 * power(np.cos(a)), 0 * a, -0.15 * power(np.sin(a))], 1)
    profile = ((0.0, 0.0), (0.9, 0.0), (0.985, 0.008), (1.04, 0.02), (1.045, 0.022), (1.04, 0.024), (0.97, 0.012),
               (0.89, 0.004), (0.0, 0.004))
    ring = lambda k, y: round_ * np.array([k, 0, k]) + (0, y, 0)
    return shapes.joined(*(sheet(np.stack([ring(*one), ring(*two)])[:, ::-1])
                           for one, two in zip(profile, profile[1:])))


def turned_ware():
    """What a lathe makes, by name."""
    vase = shapes.lathe([(0, 0), (0.042, 0)], [(0.042, 0), (0.046, 0.006), (0.043, 0.014)],
                        [(0.043, 0.014), (0.06, 0.06), (0.075, 0.11), (0.076, 0.15), (0.062, 0.19), (0.036, 0.225),
                         (0.027, 0.255), (0.031, 0.285), (0.046, 0.305)],
                        [(0.046, 0.305), (0.047, 0.308), (0.044, 0.308)],
                        [(0.044, 0.308), (0.029, 0.285), (0.025, 0.255), (0.034, 0.22), (0.0, 0.12)], segments=64)
    jug = shapes.lathe([(0, 0), (0.05, 0)], [(0.05, 0), (0.058, 0.012), (0.064, 0.05), (0.058, 0.1), (0.044, 0.14),
                                             (0.038, 0.165), (0.045, 0.19)],
                       [(0.045, 0.19), (0.042, 0.19)],
                       [(0.042, 0.19), (0.035, 0.165), (0.04, 0.14), (0, 0.05)], segments=64)
    t = np.linspace(0, 1, 30)
    handle = np.stack([0.04 + 0.065 * np.sin(np.pi * t) ** 0.8, 0.178 - 0.125 * t, 0 * t], 1)
    jug = shapes.joined(jug, swept(handle, 0.0062 - 0.002 * t, 12))
    goblet = shapes.lathe([(0, 0), (0.037, 0)],
                          [(0.037, 0), (0.038, 0.003), (0.02, 0.009), (0.007, 0.016), (0.0055, 0.05), (0.01, 0.06),
                           (0.006, 0.07), (0.012, 0.082), (0.031, 0.1), (0.039, 0.13), (0.037, 0.165)],
                          [(0.037, 0.165), (0.0355, 0.165)],
                          [(0.0355, 0.165), (0.037, 0.13), (0.029, 0.102), (0, 0.088)],
                          segments=56)
    bowl = shapes.lathe([(0, 0.0), (0.035, 0.0)], [(0.035, 0.0), (0.035, 0.008)],
                        [(0.035, 0.008), (0.07, 0.022), (0.095, 0.05), (0.104, 0.075)], [(0.104, 0.075), (0.1, 0.076)],
                        [(0.1, 0.076), (0.091, 0.052), (0.067, 0.026), (0, 0.013)], segments=64)
    candlestick = shapes.lathe([(0, 0), (0.055, 0)], [(0.055, 0), (0.056, 0.006)],
                               [(0.056, 0.006), (0.05, 0.013), (0.03, 0.018), (0.014, 0.03), (0.01, 0.05),
                                (0.018, 0.07),
                                (0.022, 0.085), (0.015, 0.1), (0.008, 0.115), (0.008, 0.18), (0.013, 0.195),
                                (0.024, 0.205)], [(0.024, 0.205), (0.024, 0.212), (0.014, 0.212)],
                               [(0.014, 0.212), (0.014, 0.235), (0.0, 0.235)], segments=48)
    return dict(vase=vase, jug=jug, goblet=goblet, bowl=bowl, candlestick=candlestick)


def studio(glb, metal):
    wall = matte(glb, "studio wall", (0.6, 0.58, 0.55))
    board = matte(glb, "baffle", (0.035, 0.035, 0.037))
    oak = printed(glb, "bench top", cloudy([0.4, 0.27, 0.17], [0.25, 0.16, 0.1], 12, seed=6))
    low, high = np.array([-1.7, -0.8, -1.1]), np.array([1.7, 1.6, 1.8])
    x, y, z = np.diag(high - low)
    for name, m in (("floor", shapes.quad(low + z, x, -z)), ("ceiling", shapes.quad(low + y, x, z)),
                    ("back", shapes.quad(low, x, y)), ("front", shapes.quad(low + z + x, -x, y)),
                    ("left", shapes.quad(low + z, -z, y)), ("right", shapes.quad(low + x, z, y))):
        glb.add(name, m, wall)
    glb.add("table", shapes.box((-0.9, -0.05, -0.5), (0.9, 0.0, 0.5), 0.5), oak)
    for sx in (-0.8, 0.8):
        for sz in (-0.42, 0.42):
            glb.add("leg", shapes.box((sx - 0.035, -0.8, sz - 0.035), (sx + 0.035, -0.05, sz + 0.035)), oak)
    t = np.linspace(0, np.pi / 2, 17)  # a sheet that rises from the table into a backdrop
    curve = np.stack([0 * t, 0.25 * (1 - np.cos(t)), -0.18 - 0.25 * np.sin(t)], 1)
    curve = np.concatenate([[(0, 0, 0.38), (0, 0, 0.1)], curve, [(0, 0.45, -0.43), (0, 0.72, -0.43)]]) + (0, 0.002, 0)
    backdrop = np.stack([curve + (side * 0.72, 0, 0) for side in (-1, 1)], 1)
    glb.add("backdrop", sheet(backdrop), metal["dark"])
    glb.add("backdrop, behind", sheet(backdrop[:, ::-1] + (0, -0.001, -0.001)), board)
    s = np.linspace(-1, 1, 25)  # a bent reflector, hollow to the table
    bent = np.stack([-1.3 + 0.22 * s**2, 0.6 + 0.6 * s, 0 * s], 1)
    reflector = np.stack([bent + (0, 0, side * 0.55 - 0.05) for side in (-1, 1)], 1)
    glb.add("reflector", sheet(reflector[:, ::-1]), metal["sheet"])
    glb.add("reflector, behind", sheet(reflector - (0.003, 0, 0)), board)


def lamp(glb, name, center, aim, width, height, strength, color):
    """A lamp in a black hood open towards `aim`: its back and sides are baffles."""
    frame = facing(np.subtract(aim, center))
    place = lambda m: shapes.mesh(m["positions"] @ frame + center, m["triangles"], m["normals"] @ frame, m["uvs"])
    w, h, deep, wall = width / 2, height / 2, 0.09, 0.004
    hood = shapes.joined(
        shapes.box((-w - wall, -h - wall, -0.01), (w + wall, h + wall, -0.002)),
        *(shapes.box(*ends) for ends in (((-w - wall, -h - wall, -0.002), (-w, h + wall, deep)),
                                         ((w, -h - wall, -0.002), (w + wall, h + wall, deep)),
                                         ((-w, -h - wall, -0.002), (w, -h, deep)),
                                         ((-w, h, -0.002), (w, h + wall, deep)))))
    glb.add(name + " hood", place(hood), matte(glb, name + " hood", (0.03, 0.03, 0.03)))
    glb.add(name, place(shapes.quad((-w, -h, 0), (2 * w, 0, 0), (0, 2 * h, 0))), lit(glb, name, strength, color))


def still_life(glb, metal):
    ware, ball, top = turned_ware(), shapes.sphere(1.0, 4), 0.002
    put = lambda name, m, material, x, z, turn=0.0, y=top, scale=1.0: glb.add(
        name, m, metal[material], (x, y, z), turn, scale)
    put("vase", ware["vase"], "copper", -0.27, -0.14)
    put("jug", ware["jug"], "silver", 0.25, -0.12, -35)
    put("candlestick", ware["candlestick"], "brass", 0.1, -0.2)
    put("candlestick", ware["candlestick"], "brass", 0.4, -0.2, scale=0.8)
    put("goblet", ware["goblet"], "gold", -0.09, -0.1)
    put("goblet", ware["goblet"], "silver", -0.15, -0.01, scale=0.85)
    put("bowl", ware["bowl"], "bronze", 0.41, 0.03)
    for x, y, z, r, material in ((0.385, 0.045, 0.02, 0.026, "chrome"), (0.435, 0.045, 0.045, 0.025, "gold"),
                                 (0.425, 0.047, -0.012, 0.025, "copper"), (0.41, 0.088, 0.018, 0.023, "steel")):
        put("ball", ball, material, x, z, y=top + y, scale=r)
    put("sphere", ball, "chrome", -0.43, 0.0, y=top + 0.075, scale=0.075)
    put("small sphere", ball, "steel", -0.33, 0.13, y=top + 0.032, scale=0.032)
    put("small sphere", ball, "gold", 0.28, 0.19, y=top + 0.022, scale=0.022)
    put("tray", tray(), "tray", 0.06, 0.11, 8)
    on_tray = top + 0.004
    put("spoon", spoon(), "silver", 0.09, 0.06, 22, on_tray)
    put("fork", fork(), "silver", 0.05, 0.115, 14, on_tray)
    put("knife", knife(), "silver", 0.06, 0.17, 12, on_tray)
    wheel, pinion = gear(24, 0.062, 0.014, 0.012), gear(13, 0.034, 0.008, 0.013)
    put("gear", wheel, "brass", -0.34, 0.27, 5)
    put("pinion", pinion, "steel", -0.237, 0.27, 9)
    put("gear on top", pinion, "bronze", -0.36, 0.25, 20, top + 0.018)
    glb.add("leaning gear", shapes.turned(wheel, 72), metal["steel"], (0.45, top + 0.066, 0.19), -25)
    t = np.linspace(0, 14 * np.pi, 240)
    coil = np.stack([0.06 * t / t[-1] - 0.03, 0.0125 + 0.011 * np.sin(t), 0.011 * np.cos(t)], 1)
    put("spring", swept(coil, 0.0014, 8), "steel", -0.13, 0.29, 35)
    a = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    link = swept(np.stack([0.014 * np.cos(a), 0.0035 + 0 * a, 0.009 * np.sin(a)], 1), 0.0028, 10, closed=True)
    for k in range(14):  # a chain that lies in a bow; every other link stands on its edge
        s = k / 13
        x, z = -0.03 + 0.27 * s, 0.315 + 0.035 * np.sin(5 * s)
        turn = -np.degrees(np.arctan2(0.035 * 5 * np.cos(5 * s), 0.27))
        m = link if k % 2 == 0 else shapes.turned(link, 55, offset=(0, 0.005, 0))
        put("link", m, "dark" if k % 4 else "brass", x, z, turn, top + 0.0005)


def main():
    glb = scene.begin("glossy", (640, 360))
    metal = metals(glb)
    studio(glb, metal)
    still_life(glb, metal)
    lamp(glb, "key lamp", (-0.72, 0.95, 0.0), (-1.3, 0.75, -0.05), 0.5, 0.5, 38, (1.0, 0.84, 0.64))
    lamp(glb, "back lamp", (0.3, 0.8, -0.2), (0.2, 0.3, -0.6), 0.6, 0.06, 30, (0.7, 0.83, 1.0))
    lamp(glb, "fill lamp", (0.9, 0.9, 1.1), (0.3, 1.6, 1.8), 0.6, 0.6, 32, (1.0, 0.95, 0.9))
    glb.camera("table", (0.08, 0.42, 1.05), (0.03, 0.075, 0.0), 33)
    scene.save(glb)


if __name__ == "__main__":
    main()
