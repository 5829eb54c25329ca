"""A small marble bust between a soft key light and a strong light from behind."""
import os

from kit import media, shapes, studio

COPYRIGHT = "Scene: CC0-1.0. Bust: scan by Nora Al-Badri and Jan Nikolai Nelles (2016), public domain"


def build(meshes):
    marble = studio.subsurface("marble", media.MARBLE, roughness=0.3)
    bust = shapes.load("bust", os.path.join(meshes, "nefertiti_bust_pd.obj"), 0.09, marble, yaw=28)
    shapes.decimate(bust, 70000)
    studio.sweep((0.055, 0.06, 0.07), back=0.35, radius=0.2)
    studio.panel("key", (-0.28, -0.26, 0.24), (0, 0, 0.05), 0.22, (6.4, 6.1, 5.7))
    studio.panel("back light", (0.16, 0.17, 0.13), (0, 0, 0.06), (0.10, 0.16), (34, 25, 16))
    studio.panel("rim", (-0.22, 0.14, 0.10), (0, 0, 0.06), (0.05, 0.20), (6, 8, 12))
    studio.camera((0.0, -0.44, 0.065), (0, 0, 0.0465), 118)
