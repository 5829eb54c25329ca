"""A trefoil knot cut from nephrite, on a slate block, with the light coming through it."""
import math

from kit import media, shapes, studio

COPYRIGHT = "CC0-1.0"


def trefoil(size, points=360):
    """A (2, 3) torus knot in the plane of x and z."""
    curve = []
    for i in range(points):
        t = 2 * math.pi * i / points
        r = 1 + 0.42 * math.cos(3 * t)
        curve.append((size * r * math.cos(2 * t + 0.52), size * 0.46 * math.sin(3 * t), size * r * math.sin(2 * t + 0.52)))
    return curve


def build(_meshes):
    jade = studio.subsurface("nephrite", media.NEPHRITE, roughness=0.3)
    slate = studio.material("slate", (0.035, 0.037, 0.04), roughness=0.45)
    brass = studio.material("brass", (0.85, 0.6, 0.28), roughness=0.28, metallic=1.0)
    knot = shapes.tube("knot", trefoil(0.0145), 0.0056, jade, sides=40)
    knot.location = (0, 0, 0.0385)
    knot.rotation_euler = (0, 0, math.radians(14))
    shapes.apply(knot)
    shapes.box("plinth", (0, 0, 0.006), (0.05, 0.032, 0.012), slate, bevel=0.0012)
    shapes.lathe("pin", [(0, 0.011), (0.0045, 0.011), (0.0045, 0.0135), (0.0012, 0.0145), (0.0011, 0.0185), (0, 0.0185)], brass, 48)
    studio.sweep((0.32, 0.30, 0.27), back=0.3, radius=0.16)
    studio.panel("back light", (0.26, 0.16, 0.16), (0, 0, 0.038), 0.26, (13, 12.3, 11))
    studio.panel("glow", (-0.26, 0.16, 0.2), (0, 0, 0.038), 0.2, (6, 6, 6.2))
    studio.panel("key", (-0.3, -0.25, 0.3), (0, 0, 0.035), 0.36, (2.0, 2.0, 2.1))
    studio.panel("fill", (0.3, -0.25, 0.12), (0, 0, 0.03), 0.2, (0.8, 0.85, 1.0))
    studio.camera((-0.03, -0.25, 0.06), (0, 0, 0.0335), 90)
