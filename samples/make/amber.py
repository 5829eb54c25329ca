"""A beetle and bubbles of air in a piece of amber."""
import math

import numpy as np

from kit import media, noise, shapes, studio

COPYRIGHT = "CC0-1.0"
MM = 0.001


def build(_meshes):
    amber = studio.subsurface("amber", media.AMBER, roughness=0.03, thickness=0.018)
    air = studio.subsurface("air", media.AIR.with_(priority=1), roughness=0.0, thickness=0.001)
    shell = studio.material("shell", (0.022, 0.011, 0.006), roughness=0.25)
    leg = studio.material("legs", (0.012, 0.007, 0.004), roughness=0.4)

    stone = shapes.ellipsoid("amber", (0, 0, 0), (18.5 * MM, 11 * MM, 14 * MM), amber, subdivisions=6)
    pebble(stone)
    stone.rotation_euler = (math.radians(8), math.radians(-6), math.radians(12))
    shapes.apply(stone)
    lowest = min(v.co.z for v in stone.data.vertices)
    stone.location = (0, 0, -lowest)
    shapes.apply(stone)

    beetle((-0.5 * MM, -0.8 * MM, 13.6 * MM), shell, leg)
    bubbles = [(8.8, -1.5, 19.3, 1.0), (10.6, 1.0, 17.0, 0.55), (-10.4, -2.0, 16.6, 0.75), (-8.8, 0.4, 8.4, 0.45),
               (6.2, -2.2, 7.2, 0.6), (11.0, -0.5, 12.0, 0.35), (-4.6, 1.5, 22.0, 0.5)]
    shapes.join("bubbles", [shapes.ellipsoid(f"bubble {i}", (x * MM, y * MM, z * MM), (r * MM,) * 3, air, 3)
                            for i, (x, y, z, r) in enumerate(bubbles)])
    studio.sweep((0.62, 0.6, 0.56), back=0.22, radius=0.12)
    studio.panel("back light", (0.05, 0.15, 0.085), (0, 0, 0.012), (0.16, 0.09), (9.5, 9.3, 9.0))
    studio.panel("wall light", (-0.12, -0.02, 0.3), (0.02, 0.22, 0.06), (0.2, 0.08), (6.0, 5.9, 5.7))
    studio.panel("key", (-0.2, -0.1, 0.18), (0, 0, 0.01), 0.14, (5.0, 4.9, 4.7))
    studio.panel("edge", (0.2, -0.04, 0.06), (0, 0, 0.014), (0.05, 0.14), (4.0, 4.2, 4.6))
    studio.camera((0.012, -0.20, 0.045), (0, 0, 0.0145), 105)


def pebble(item):
    """Swells and dents an ellipsoid smoothly, by a few percent of its size."""
    mesh = item.data
    p = np.array([v.co for v in mesh.vertices])
    offset = 1 + 0.09 * (noise.smooth(p / 0.012, seed=3) - 0.5) + 0.05 * (noise.smooth(p / 0.006, seed=8) - 0.5)
    for vertex, co in zip(mesh.vertices, p * offset[:, None]):
        vertex.co = co


def beetle(at, shell, leg):
    """Ellipsoids and bent tubes, 11 mm long, seen from its right and above."""
    def part(name, centre, half, material, turn=(0, 0, 0)):
        return shapes.ellipsoid(name, [c * MM for c in centre], [h * MM for h in half], material, 4, turn)

    parts = [part("abdomen", (1.6, 0, 0.2), (3.5, 2.3, 1.7), shell), part("thorax", (-2.2, 0, 0.25), (1.5, 1.8, 1.35), shell),
             part("head", (-4.1, 0, 0.1), (0.95, 1.05, 0.85), shell)]
    legs = []
    for side in (-1, 1):
        for base, reach, foot in ((-2.9, 1.3, -1.5), (-1.6, 0.1, 0.1), (0.2, -1.2, 1.8)):
            path = [(base, side * 1.2, -0.5), (base - 0.25 * reach, side * 2.9, 0.8), (base - 0.6 * reach + 0.2 * foot, side * 3.9, -1.2),
                    (base - 0.9 * reach + 0.4 * foot, side * 4.7, -2.2)]
            legs.append(limb(path, (0.32, 0.26, 0.2, 0.1), leg))
        legs.append(limb([(-4.6, side * 0.5, 0.5), (-5.8, side * 1.4, 1.4), (-7.0, side * 1.6, 1.2)], (0.13, 0.11, 0.07), leg))
    body = shapes.join("beetle", parts + legs)
    body.rotation_euler = (math.radians(38), math.radians(14), math.radians(10))
    body.location = at
    return shapes.apply(body)


def limb(points, radii, material, sides=10, steps=8):
    """A tapering tube through points, with pointed ends."""
    p, r = np.array(points, float) * MM, np.array(radii) * MM
    t = np.linspace(0, len(p) - 1, steps * (len(p) - 1) + 1)
    curve = np.stack([np.interp(t, range(len(p)), p[:, i]) for i in range(3)], 1)
    for _ in range(4):
        curve[1:-1] = (curve[:-2] + 2 * curve[1:-1] + curve[2:]) / 4
    radius = np.interp(t, range(len(p)), r)
    tangent = np.gradient(curve, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    side = np.cross(tangent, (0.2, 0.1, 1.0))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    other = np.cross(tangent, side)
    vertices = [curve[i] + radius[i] * (math.cos(a) * side[i] + math.sin(a) * other[i])
                for i in range(len(curve)) for a in 2 * math.pi * np.arange(sides) / sides]
    faces = shapes.grid_faces(len(curve), sides, False, True)
    first, last = len(vertices), len(vertices) + 1
    vertices += [curve[0] - tangent[0] * radius[0], curve[-1] + tangent[-1] * radius[-1]]
    end = (len(curve) - 1) * sides
    for i in range(sides):
        j = (i + 1) % sides
        faces += [(first, j, i), (last, end + i, end + j)]
    return shapes.from_arrays("limb", vertices, faces, material)
