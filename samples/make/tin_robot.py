"""A wind-up tin robot: the core material with all its textures, and nothing below the surface."""
import math

import numpy as np

from kit import noise, paint, shapes, studio

COPYRIGHT = "CC0-1.0"
MM = 0.001
TIN = np.array((0.62, 0.60, 0.56))
RED, CREAM, TEAL = np.array((0.50, 0.035, 0.02)), np.array((0.62, 0.55, 0.40)), np.array((0.035, 0.22, 0.22))


def build(_meshes):
    steel = studio.material("steel", (0.56, 0.57, 0.58), roughness=0.28, metallic=1.0)
    brass = studio.material("brass", (0.83, 0.6, 0.27), roughness=0.3, metallic=1.0)
    rubber = studio.material("rubber", (0.018, 0.018, 0.02), roughness=0.75)
    lit = studio.material("eyes", (0.1, 0.08, 0.04), roughness=0.2, emission=(9.0, 5.2, 1.6))
    lamp = studio.material("lamp glass", (0.55, 0.02, 0.015), roughness=0.12, emission=(0.9, 0.03, 0.02))

    enamel("body", (0, 0, 42), (36, 26, 32), 4.5, RED)
    enamel("head", (0, 0, 73.5), (27, 22, 19), 3.5, CREAM)
    for side in (-1, 1):
        enamel(f"foot {side}", (side * 9.2, -2.5, 4.5), (13.5, 22, 9), 2.8, TEAL)
        turned("leg", (side * 9.2, 0, 8), [(0, 0), (5, 0), (5, 18.5), (0, 18.5)], 0.5, steel)
        turned("knee", (side * 9.2, 0, 14.5), [(0, 0), (5.9, 0), (5.9, 3), (0, 3)], 0.9, rubber)
        turned("shoulder", (side * 18, 0, 52), [(0, 0), (5.6, 0), (5.6, 4), (0, 4)], 1.4, steel, (0, side * 90, 0))
        arm(side, steel, rubber)
        turned("eye", (side * 6, -10.6, 76), [(0, 0), (4.2, 0), (4.2, 1.6), (3.2, 1.6), (3.2, 0.9), (0, 0.9)], 0.35, brass, (90, 0, 0))
        shapes.ellipsoid("pupil", (side * 6 * MM, -11.4 * MM, 76 * MM), (2.9 * MM, 1.1 * MM, 2.9 * MM), lit, 3)
        turned("ear", (side * 13, 0, 73.5), [(0, 0), (5.2, 0), (5.2, 2), (2, 3.2), (2, 5), (0, 5)], 0.5, brass, (0, side * 90, 0))
    turned("neck", (0, 0, 57), [(0, 0), (6.5, 0), (6.5, 8), (0, 8)], 0.4, rubber)
    turned("antenna", (0, 0, 82), [(0, 0), (4, 0), (2.4, 2), (0.75, 3.2), (0.75, 12), (0, 12)], 0.4, steel)
    shapes.ellipsoid("lamp", (0, 0, 95.5 * MM), (2.9 * MM,) * 3, lamp, 3)
    chest(steel, brass, rubber)
    for i in range(5):
        shapes.box(f"tooth {i}", ((i - 2) * 3.4 * MM, -10.9 * MM, 67.6 * MM), (2.4 * MM, 1.6 * MM, 3.2 * MM), steel, 0.4 * MM)
    for item in list(shapes.bpy.data.objects):
        if item.type == "MESH" and len(item.data.polygons) < 20000:
            item.data.set_sharp_from_angle(angle=math.radians(40))

    studio.sweep((0.72, 0.50, 0.24), back=0.34, radius=0.2, roughness=0.55)
    studio.panel("key", (-0.24, -0.24, 0.28), (0, 0, 0.04), 0.22, (5.4, 5.3, 5.1))
    studio.panel("strip", (0.28, -0.06, 0.14), (0, 0, 0.05), (0.06, 0.3), (5.0, 5.2, 5.6))
    studio.panel("back light", (0.1, 0.24, 0.24), (0, 0, 0.05), 0.12, (8.0, 7.6, 7.0))
    studio.camera((0.10, -0.40, 0.105), (0.0, 0, 0.0485), 100)


def turned(name, at, points, rounding, material, turn=(0, 0, 0)):
    item = shapes.lathe(name, shapes.rounded([(r * MM, z * MM) for r, z in points], rounding * MM), material, 64)
    item.location = [c * MM for c in at]
    item.rotation_euler = [math.radians(a) for a in turn]
    return shapes.apply(item)


def arm(side, steel, rubber):
    x = side * 23.5
    turned("upper arm", (x, 0, 34), [(0, 0), (3.6, 0), (3.6, 17.5), (0, 19)], 1.2, steel)
    turned("cuff", (x, 0, 33), [(0, 0), (4.8, 0), (4.8, 3.2), (0, 3.2)], 0.9, rubber)
    points = np.array([(0, 5.0, -6.5), (0, 6.2, -2), (0, 3.6, 2.6), (0, -3.6, 2.6), (0, -6.2, -2), (0, -5.0, -6.5)])
    t = np.linspace(0, 5, 60)
    out = np.stack([np.interp(t, range(6), points[:, i]) for i in range(3)], 1)
    for _ in range(30):
        out[1:-1] = (out[:-2] + 2 * out[1:-1] + out[2:]) / 4
    back = out[::-1] * (1, 0.72, 0.72) + (0, 0, 0)
    claw = np.concatenate([out, back])
    shapes.tube("claw", claw * MM + np.array((x, 0, 29)) * MM, 1.15 * MM, steel, 16)


def chest(steel, brass, rubber):
    shapes.box("plate", (0, -13.1 * MM, 42 * MM), (27 * MM, 1.4 * MM, 22 * MM), steel, 0.6 * MM)
    for x, z, r in ((-7.6, 46.5, 3.6), (0, 46.5, 2.4), (7.6, 46.5, 3.6)):
        turned("dial", (x, -13.6, z), [(0, 0), (r, 0), (r, 1.5), (r - 0.7, 1.5), (r - 0.7, 0.9), (0, 0.9)], 0.25, brass, (90, 0, 0))
        angle = 0.9 * x / 7.6
        shapes.box("needle", (x * MM, -14.9 * MM, z * MM), (0.45 * MM, 0.5 * MM, 1.5 * r * MM), rubber, 0.1 * MM, rotation=(0, angle, 0))
    for i in range(6):
        shapes.box(f"slot {i}", (0, -13.85 * MM, (33.6 + 1.5 * i) * MM), (20 * MM, 0.5 * MM, 0.75 * MM), rubber, 0.1 * MM)


def enamel(name, centre, size, bevel, color):
    """A painted box, worn at its edges down to the tin, on a hammered surface."""
    material = studio.material(name, roughness=1.0)
    centre, half = np.array(centre) * MM, np.array(size) * MM / 2
    item = shapes.box(name, centre, tuple(2 * half), material, bevel * MM, 6)
    paint.unwrap(item, 40.0, 0.02)
    points, covered = paint.positions(item, 512)
    p = points.reshape(-1, 3)
    edge = np.sort(np.abs(p - centre) - (half - bevel * MM), axis=1)[:, 1] / (bevel * MM)
    wear = np.clip(edge, -0.4, 1) + 1.5 * (noise.fractal(p / 0.0035, 4, 11) - 0.5) + 0.35 * (noise.fractal(p / 0.03, 2, 5) - 0.5)
    bare = np.clip((wear - 0.66) / 0.06, 0, 1)[:, None]
    grime = 0.82 + 0.18 * noise.fractal(p / 0.012, 3, 3)[:, None]
    base = (1 - bare) * color * grime + bare * TIN * (0.75 + 0.25 * grime)
    roughness = (1 - bare) * (0.26 + 0.2 * noise.fractal(p / 0.006, 3, 9)[:, None]) + bare * 0.42
    surface = np.concatenate([np.ones_like(bare), roughness, bare], 1)
    shape = (*points.shape[:2], 3)
    texture(material, name, srgb(base).reshape(shape), surface.reshape(shape), hammered(points, covered))
    return item


def hammered(points, covered):
    """A tangent-space normal map of shallow dents; texel spacing stands for length."""
    height = (0.4 * noise.smooth(points.reshape(-1, 3) / 0.0024, 21)).reshape(points.shape[:2])
    dx, dy = (np.where(covered & np.roll(covered, 1, a) & np.roll(covered, -1, a),
                       np.roll(height, -1, a) - np.roll(height, 1, a), 0.0) for a in (1, 0))
    normal = np.stack([-2.2 * dx, 2.2 * dy, np.ones_like(dx)], -1)
    return 0.5 + 0.5 * normal / np.linalg.norm(normal, axis=-1, keepdims=True)


def srgb(linear):
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)


def texture(material, name, base, surface, normal):
    """Links the three images to the Principled node as the exporter expects them."""
    tree = material.node_tree
    shader = studio.principled(material)

    def node(kind, image=None):
        n = tree.nodes.new(kind)
        if image is not None:
            n.image = image
        return n

    color = node("ShaderNodeTexImage", studio.image(f"{name} base color", base, color=True))
    tree.links.new(color.outputs["Color"], shader.inputs["Base Color"])
    packed = node("ShaderNodeTexImage", studio.image(f"{name} metallic roughness", surface))
    split = node("ShaderNodeSeparateColor")
    tree.links.new(packed.outputs["Color"], split.inputs["Color"])
    tree.links.new(split.outputs["Green"], shader.inputs["Roughness"])
    tree.links.new(split.outputs["Blue"], shader.inputs["Metallic"])
    bump = node("ShaderNodeTexImage", studio.image(f"{name} normal", normal))
    tangent = node("ShaderNodeNormalMap")
    tree.links.new(bump.outputs["Color"], tangent.inputs["Color"])
    tree.links.new(tangent.outputs["Normal"], shader.inputs["Normal"])
