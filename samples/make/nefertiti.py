"""A small marble bust between a soft key light and a strong light from behind."""
import os

from kit import media, shapes, studio

COPYRIGHT = "Scene: CC0-1.0. Bust: scan by Nora Al-Badri and Jan Nikolai Nelles (2016), public domain"


def build(meshes):
    marble = studio.subsurface("marble", media.MARBLE, roughness=0.42)
    bust = shapes.load("bust", os.path.join(meshes, "nefertiti_bust_pd.obj"), 0.09, marble, yaw=28)
    shapes.decimate(bust, 70000)
    studio.sweep((0.055, 0.06, 0.07), back=0.45, radius=0.2)
    studio.panel("key", (-0.4, -0.36, 0.34), (0, 0, 0.05), 0.4, (3.9, 3.75, 3.5))
    studio.panel("back light", (0.34, 0.24, 0.2), (0, 0, 0.06), (0.28, 0.3), (19, 14, 9))
    studio.panel("rim", (-0.34, 0.2, 0.16), (0, 0, 0.06), (0.12, 0.3), (2.6, 3.5, 5))
    studio.camera((0.0, -0.44, 0.065), (0, 0, 0.0465), 118)
