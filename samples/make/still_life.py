"""Supper: candle, grapes, cheese and an apple, lit by a flame, a lamp and the window."""
import math

import numpy as np

from kit import media, shapes, studio

COPYRIGHT = "CC0-1.0"
MM = 0.001


def profile(points, radius):
    return shapes.rounded([tuple(v * MM for v in p) for p in points], radius * MM)


def build(_meshes):
    table = studio.material("table", (0.16, 0.075, 0.035), roughness=0.42)
    copper = studio.material("copper", (0.93, 0.52, 0.36), roughness=0.24, metallic=1.0)
    board = studio.material("board", (0.36, 0.2, 0.095), roughness=0.55)
    candle((-44, 26))
    cheese((30, 0))
    grapes((-4, -20))
    apple((76, 34))
    shapes.box("board", (34 * MM, 2 * MM, 3.5 * MM), (70 * MM, 46 * MM, 7 * MM), board, bevel=1.5 * MM, rotation=(0, 0, math.radians(-8)))
    cup = shapes.lathe("cup", profile([(0, 0), (17, 0), (21, 46), (19.8, 46), (16.2, 2), (0, 1.6)], 0.55), copper, 96)
    cup.location = (6 * MM, 46 * MM, 0)
    shapes.apply(cup)
    studio.sweep((0.14, 0.105, 0.085), back=0.32, radius=0.14, roughness=0.7)
    shapes.box("table", (0, 0.02, -0.0105), (0.6, 0.42, 0.02), table, bevel=0.003)

    studio.panel("window", (-0.42, -0.12, 0.34), (0, 0, 0.03), 0.5, (1.6, 1.8, 2.0))
    studio.lamp("lamp", "SPOT", (0.32, 0.02, 0.30), (1.0, 0.78, 0.52), 1.5, (0.02, 0, 0.02), angle=46, blend=0.5)
    studio.camera((0.02, -0.40, 0.15), (0.014, 0, 0.040), 82)


def candle(at):
    x, y = (v * MM for v in at)
    wax = studio.subsurface("wax", media.WAX, roughness=0.5)
    body = shapes.lathe("candle", profile([(0, 0), (16, 0), (16, 68), (12.5, 67.2), (6, 62.5), (0, 61.5)], 1.6), wax, 96)
    body.location = (x, y, 0.4 * MM)
    shapes.apply(body)
    wick = shapes.lathe("wick", [(0, 61 * MM), (0.7 * MM, 61 * MM), (0.7 * MM, 69 * MM), (0.4 * MM, 71 * MM), (0, 71 * MM)],
                        studio.material("wick", (0.01, 0.009, 0.008), roughness=0.9), 24)
    flame = shapes.lathe("flame", profile([(0, 69.5), (2.6, 71.5), (3.4, 76), (2.0, 84), (0.7, 90), (0, 93)], 2.5),
                         studio.emitter("flame", (420.0, 245.0, 92.0)), 32)
    for item in (wick, flame):
        item.location = (x, y, 0.4 * MM)
        shapes.apply(item)


def grapes(at):
    medium = studio.subsurface("grape", media.GRAPE, roughness=0.3)
    places = [(-16, -4, 0), (0, -8, 0), (15, -5, 0), (-8, 8, 0), (8, 7, 0), (-24, 9, 0), (0, 1.5, 12.4), (-14, 4, 12.2), (22, 8, 0)]
    parts = []
    random = np.random.default_rng(4)
    for i, (x, y, z) in enumerate(places):
        r = 7.6 + 0.5 * random.random()
        parts.append(shapes.ellipsoid(f"grape {i + 1}", ((at[0] + x) * MM, (at[1] + y) * MM, (r + z + 0.2) * MM),
                                      (r * MM * 0.97, r * MM * 0.97, r * MM * 1.04), medium, 4,
                                      tuple(0.6 * (random.random(3) - 0.5))))
    shapes.join("grapes", parts)


def cheese(at):
    """A wedge with holes, cut by Blender's exact boolean."""
    medium = studio.subsurface("cheese", media.CHEESE, roughness=0.55)
    angle, radius, height = math.radians(46), 52 * MM, 24 * MM
    n = 24
    outline = [(0.0, 0.0)] + [(radius * math.cos(angle * (i / n - 0.5)), radius * math.sin(angle * (i / n - 0.5))) for i in range(n + 1)]
    low = [(x, y, 0) for x, y in outline]
    high = [(x, y, height) for x, y in outline]
    count = len(outline)
    faces = [tuple(reversed(range(count))), tuple(range(count, 2 * count))]
    faces += [(i, (i + 1) % count, count + (i + 1) % count, count + i) for i in range(count)]
    wedge = shapes.from_arrays("cheese", low + high, faces, medium, smooth=False)
    shapes.modify(wedge, "BEVEL", width=0.9 * MM, segments=3, limit_method="ANGLE", angle_limit=math.radians(30))
    holes = [(22, -8.5, 15, 5.0), (36, -14.5, 9, 4.2), (30, -3, 24, 4.6), (44, 4, 23, 3.4), (44, -17, 18, 3.0), (16, -4, 6, 3.0),
             (16, 1, 24.5, 2.6), (38, 9, 25, 2.8)]
    cutters = [shapes.ellipsoid(f"hole {i}", (x * MM, y * MM, z * MM), (r * MM,) * 3, None, 3) for i, (x, y, z, r) in enumerate(holes)]
    cutter = shapes.join("holes", cutters)
    shapes.modify(wedge, "BOOLEAN", operation="DIFFERENCE", object=cutter, solver="EXACT")
    shapes.bpy.data.objects.remove(cutter)
    shapes.weld(wedge, 20e-6)
    shapes.smooth_shade(wedge)
    wedge.data.set_sharp_from_angle(angle=math.radians(35))
    wedge.location = ((at[0] - 22) * MM, (at[1] - 2) * MM, 7.4 * MM)
    wedge.rotation_euler = (0, 0, math.radians(14))
    shapes.apply(wedge)


def apple(at):
    medium = studio.subsurface("apple", media.APPLE, roughness=0.36)
    points = []
    for i in range(41):
        t = math.pi * i / 40
        r = 31 * math.sin(t) * (1 + 0.08 * math.cos(t))
        z = -27 * math.cos(t) * (1 - 0.12 * math.sin(t)) + 7 * math.exp(-(r / 7.0) ** 2) * (1 if t < 1.5 else -1)
        points.append((max(r, 0) * MM, z * MM))
    points[0], points[-1] = (0, points[0][1]), (0, points[-1][1])
    low = min(z for _, z in points)
    body = shapes.lathe("apple", [(r, z - low) for r, z in points], medium, 96)
    body.rotation_euler = (math.radians(-6), math.radians(9), 0)
    body.location = (at[0] * MM, at[1] * MM, 0.8 * MM)
    shapes.apply(body)
    twig = shapes.lathe("stem", [(0, 0), (1.0 * MM, 0), (0.8 * MM, 8 * MM), (1.2 * MM, 14 * MM), (0, 14.3 * MM)],
                studio.material("stem", (0.11, 0.07, 0.03), roughness=0.8), 24)
    twig.location = ((at[0] + 7.5) * MM, (at[1] + 4.5) * MM, 43 * MM)
    twig.rotation_euler = (math.radians(-14), math.radians(20), 0)
    shapes.apply(twig)
