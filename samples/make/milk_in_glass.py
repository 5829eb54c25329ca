"""A tumbler of skim milk: nested media whose surfaces do not have to coincide.

The wall of the glass is a closed mesh of its own. The milk is modelled half a millimetre larger than the space inside,
so that it reaches into the wall, and the glass has the higher priority: the wall cuts the milk off exactly.
"""
from kit import media, shapes, studio

COPYRIGHT = "CC0-1.0"
MM = 0.001


def profile(points, radius):
    return shapes.rounded([tuple(v * MM for v in p) for p in points], radius * MM)


def build(_meshes):
    glass = studio.subsurface("glass", media.GLASS.with_(priority=1), roughness=0.0, thickness=0.003)
    milk = studio.subsurface("skim milk", media.SKIM_MILK, roughness=0.2)
    wood = studio.material("tray", (0.19, 0.085, 0.035), roughness=0.4)
    biscuit = studio.material("biscuit", (0.52, 0.28, 0.1), roughness=0.8)

    shapes.lathe("tumbler", profile([(0, 0), (25.5, 0), (31, 84), (28.6, 84), (23.3, 10), (0, 8.5)], 1.15), glass, 128)
    # inside of the wall at height z: radius 23.3 + (z - 10) * 5.3 / 74
    radius = lambda z: 23.3 + (z - 10) * 5.3 / 74
    shapes.lathe("milk", [(0, 8.0 * MM)] + [(r * MM, z * MM) for r, z in
                 [(20, 9.2), (23.2, 9.4), (radius(20) + 0.5, 20), (radius(40) + 0.5, 40), (radius(60) + 0.5, 60),
                  (radius(62.3) + 0.5, 62.3), (radius(62) - 0.5, 61.6), (radius(62) - 1.3, 61.15), (radius(62) - 3, 61), (12, 61)]]
                 + [(0, 61 * MM)], milk, 128)
    for i, (x, y, turn) in enumerate([(52, 4, 10), (53.5, 2, 50), (51.5, 5, 80)]):
        disc = shapes.lathe(f"biscuit {i + 1}", profile([(0, 0), (19, 0), (19, 6), (0, 6.6)], 2.4), biscuit, 64)
        disc.location = (x * MM, y * MM, (4 + 6.7 * i) * MM)
    shapes.lathe("plate", profile([(0, 0), (16, 0), (26, 4), (25.6, 4.6), (15.6, 1.2), (0, 1.2)], 0.25),
                 studio.material("plate", (0.75, 0.75, 0.72), roughness=0.15), 128).location = (52 * MM, 4 * MM, 0.3 * MM)
    for item in [o for o in shapes.bpy.data.objects if o.name.startswith(("biscuit", "plate"))]:
        shapes.apply(item)
    shapes.ellipsoid("drop 1", (-38 * MM, -28 * MM, 0.9 * MM), (6 * MM, 5 * MM, 1.6 * MM), milk)
    shapes.ellipsoid("drop 2", (-26 * MM, -36 * MM, 0.6 * MM), (2.4 * MM, 2.2 * MM, 1.1 * MM), milk)
    for drop in ("drop 1", "drop 2"):
        flatten(shapes.bpy.data.objects[drop], 0.12 * MM)
    studio.sweep((0.07, 0.105, 0.14), back=0.45, radius=0.2, roughness=0.5)
    studio.panel("window", (-0.4, 0.02, 0.28), (0, 0, 0.05), 0.4, (6, 5.85, 5.6))
    studio.panel("back light", (0.28, 0.28, 0.26), (0, 0, 0.05), 0.26, (16, 13.5, 10))
    studio.panel("fill", (0.25, -0.35, 0.3), (0, 0, 0.04), 0.25, (2.2, 2.25, 2.4))
    studio.camera((-0.03, -0.36, 0.15), (0.012, 0, 0.037), 85)


def flatten(item, height):
    """Presses what is below a height up to it: a drop that stands on the table."""
    for vertex in item.data.vertices:
        if vertex.co.z < height:
            vertex.co.z = height - 0.02 * (height - vertex.co.z)
