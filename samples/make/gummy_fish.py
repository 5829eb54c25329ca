"""Three gummy fish: forward scattering (g = 0.85), between clear and cloudy."""
import math
import os

from kit import media, shapes, studio

COPYRIGHT = "Scene: CC0-1.0. Fish: \"Blub\" by Keenan Crane, CC0-1.0"
GEL = media.Medium((0, 0, 0), (330.0, 330.0, 330.0), 0.85, ior=1.42)
FLAVOURS = {"cherry": (14.0, 230.0, 260.0), "orange": (8.0, 66.0, 420.0), "lime": (120.0, 18.0, 240.0)}


def build(meshes):
    places = {"cherry": ((-0.023, -0.010), 62), "orange": ((0.024, -0.014), 122), "lime": ((0.000, 0.034), 80)}
    for name, ((x, y), yaw) in places.items():
        gel = studio.subsurface(name, GEL.with_(absorption=FLAVOURS[name]), roughness=0.2)
        fish = shapes.load(f"{name} fish", os.path.join(meshes, "blub_fish_pd.obj"), 0.029, gel, yaw=yaw)
        fish.location = (x, y, 0)
        shapes.smooth_shade(shapes.apply(fish))
    studio.sweep((0.8, 0.79, 0.77), back=0.26, radius=0.16, roughness=0.35)
    studio.panel("back light", (0.0, 0.17, 0.14), (0, 0, 0.0), (0.3, 0.1), (9.0, 8.8, 8.5))
    studio.panel("key", (-0.22, -0.1, 0.24), (0, 0, 0.0), 0.14, (3.2, 3.2, 3.3))
    studio.panel("edge", (0.22, 0.03, 0.06), (0, 0, 0.01), (0.12, 0.06), (7.0, 6.6, 6.0))
    studio.camera((0.0, -0.23, 0.12), (0.0, 0.006, 0.009), 80)
