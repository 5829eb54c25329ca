"""A cow of white and dark chocolate: coefficients painted on the surface and meant all the way through."""
import os

import numpy as np

from kit import gltf_subsurface, media, noise, paint, shapes, studio

COPYRIGHT = "Scene: CC0-1.0. Cow: \"Spot\" by Keenan Crane, CC0-1.0"
CHOCOLATE = media.Medium((150.0, 290.0, 480.0), (680.0, 660.0, 640.0), ior=1.46)
# fractions of the absorption above: white chocolate, dark chocolate, strawberry
WHITE, DARK, ROSE = np.array((0.035, 0.035, 0.08)), np.array((1.0, 1.0, 1.0)), np.array((0.06, 0.3, 0.14))
HEIGHT, YAW = 0.058, 148


def build(meshes):
    chocolate = studio.subsurface("chocolate", CHOCOLATE, roughness=0.42)
    cow = shapes.load("cow", os.path.join(meshes, "spot_pd.obj"), HEIGHT, chocolate, yaw=YAW)
    shapes.smooth_shade(cow)
    paint.unwrap(cow)
    front = facing(cow)
    absorption = paint.paint(cow, 512, lambda p: mixture(p, front))
    scattering = paint.paint(cow, 512, lambda p: np.repeat(1 - 0.35 * patches(p)[:, None], 3, 1))
    gltf_subsurface.link_texture(chocolate, "Absorption", studio.image("absorption", absorption))
    gltf_subsurface.link_texture(chocolate, "Scattering", studio.image("scattering", scattering))

    studio.sweep((0.33, 0.52, 0.6), back=0.42, radius=0.2)
    studio.panel("key", (-0.34, -0.3, 0.34), (0, 0, 0.03), 0.36, (3.2, 3.1, 2.9))
    studio.panel("back light", (0.3, 0.24, 0.2), (0, 0, 0.03), 0.26, (10, 9.1, 7.8))
    studio.panel("fill", (0.3, -0.28, 0.1), (0, 0, 0.03), 0.2, (1.0, 1.1, 1.3))
    studio.camera((0.03, -0.30, 0.075), (0, 0, 0.0275), 105)


def facing(cow):
    """The muzzle: the foremost point."""
    p = np.array([v.co for v in cow.data.vertices])
    axis = np.array((-np.sin(np.radians(YAW)), np.cos(np.radians(YAW)), 0.0))
    return p[np.argmax(p @ axis)]


def patches(p):
    """1 inside the cow's patches, 0 outside, with edges a millimetre wide."""
    field = noise.smooth(p / 0.019 + 7.3, seed=5) + 0.12 * noise.fractal(p / 0.005, 3, seed=2)
    t = np.clip((field - 0.6) / 0.05, 0, 1)
    return t * t * (3 - 2 * t)


def mixture(p, muzzle):
    near = np.clip((0.0125 - np.linalg.norm(p - muzzle, axis=1)) / 0.003, 0, 1)[:, None]
    patch = patches(p)[:, None] * (1 - near)
    skin = WHITE + (ROSE - WHITE) * near
    return np.exp((1 - patch) * np.log(skin) + patch * np.log(DARK))
