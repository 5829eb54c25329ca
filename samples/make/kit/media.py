"""Coefficients of the matter in the samples, per metre, and what else of a medium a material needs.

Measured values are those of

- Jensen, Marschner, Levoy, Hanrahan, "A Practical Model for Subsurface Light Transport", SIGGRAPH 2001, figure 5
  (reduced scattering, so with anisotropy 0);
- Narasimhan et al., "Acquiring Scattering Properties of Participating Media by Dilution", SIGGRAPH 2006.

Both tables are per millimetre. The others are chosen by eye to resemble the real thing, and say so.
"""
from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Medium:
    """Coefficients per metre (RGB), mean cosine, index of refraction, dilution and rank where meshes overlap."""

    absorption: tuple = (0.0, 0.0, 0.0)
    scattering: tuple = (0.0, 0.0, 0.0)
    anisotropy: float = 0.0
    ior: float = 1.5
    density: float = 1.0
    priority: int = 0

    def with_(self, **changes):
        return replace(self, **changes)

    @property
    def extinction(self):
        return tuple(self.density * (a + s) for a, s in zip(self.absorption, self.scattering))


def per_millimetre(absorption, scattering, **rest):
    return Medium(tuple(round(1000 * v, 6) for v in absorption), tuple(round(1000 * v, 6) for v in scattering), **rest)


# Jensen et al. 2001
MARBLE = per_millimetre((0.0021, 0.0041, 0.0071), (2.19, 2.62, 3.00), ior=1.5)
SKIM_MILK = per_millimetre((0.0014, 0.0025, 0.0142), (0.70, 1.22, 1.90), ior=1.3)
APPLE = per_millimetre((0.003, 0.0034, 0.046), (2.29, 2.39, 1.97), ior=1.3)

# Chosen by eye
GLASS = Medium((1.2, 0.4, 0.9), ior=1.52)
WAX = Medium((4.0, 14.0, 55.0), (900.0, 850.0, 800.0), ior=1.43)
NEPHRITE = Medium((62.0, 20.0, 46.0), (620.0, 680.0, 640.0), ior=1.61)
AMBER = Medium((3.0, 26.0, 150.0), (4.0, 4.0, 4.0), 0.7, ior=1.54)
AIR = Medium(ior=1.0)
GRAPE = Medium((26.0, 9.0, 84.0), (420.0, 420.0, 420.0), 0.8, ior=1.36)
CHEESE = Medium((5.0, 26.0, 190.0), (1000.0, 1000.0, 900.0), ior=1.38)
