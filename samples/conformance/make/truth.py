"""Numbers that no renderer made: closed forms of clear and absorbing layers, tabulated slabs, and a small simulation.

`simulate` follows photons through one slab, by itself. It supplies what typical *mistakes* would show, to about one per
cent; expectations come from closed forms and from `tables.json`.
"""
import json
import pathlib

import numpy as np

TABLES = json.loads((pathlib.Path(__file__).parent / "tables.json").read_text())


def fresnel(cos_i, n):
    """Reflectance for unpolarized light that comes from index 1 at that cosine to index n."""
    cos_t = np.sqrt(1 - (1 - cos_i**2) / n**2)
    s = (cos_i - n * cos_t) / (cos_i + n * cos_t)
    p = (n * cos_i - cos_t) / (n * cos_i + cos_t)
    return 0.5 * (s * s + p * p)


def square_of_ball(radius, half, n):
    """Mean reflectance of a ball's surface over the square of half width `half` in its middle, seen along parallel rays."""
    x = (np.arange(64) + 0.5) / 64 * half
    cos = np.sqrt(1 - (x[:, None] ** 2 + x[None, :] ** 2) / radius**2)
    return fresnel(cos, n).mean()


def pile(layers):
    """Reflectance and transmittance of layers (R, T) from both sides alike, by adding: light bounces between them.

    Interfaces are (F, 1 − F), absorbing layers (0, e^(−σa l)).
    """
    r_top, r_bottom, t = 0.0, 0.0, 1.0
    for r, through in layers:
        loop = 1 / (1 - r_bottom * r)
        r_top, r_bottom, t = r_top + t * t * r * loop, r + through * through * r_bottom * loop, t * through * loop
    return r_top, t


def without_priorities(tau_upper, tau_lower, n):
    """What two overlapping slabs show, both sides lit by 1, where each surface sets the medium of its own side: going on
    from a surface, up or down, reflected or not, light is in the medium that the *same* body has there, or in none.

    Surfaces 0 to 3 from below are those of the lower, upper, lower and upper slab; tau is that of a distance between two.
    """
    f = fresnel(1.0, n)
    behind = {1: (tau_lower, tau_upper, 0, 0), -1: (0, 0, tau_lower, tau_upper)}
    states = [(surface, way) for surface in range(4) for way in (1, -1)]
    matrix, right = np.eye(8), np.zeros(8)
    for row, (surface, way) in enumerate(states):
        for share, onward in ((1 - f, way), (f, -way)):
            share *= np.exp(-behind[onward][surface])
            if 0 <= surface + onward <= 3:
                matrix[row, states.index((surface + onward, onward))] -= share
            else:
                right[row] += share
    return np.linalg.solve(matrix, right)[states.index((3, -1))]


def clear(tau, n, cos_i=1.0, tint=1.0):
    """R and T of a smooth slab that absorbs e^(−tau) at normal incidence; `tint` multiplies at each crossing."""
    f = fresnel(cos_i, n)
    a = np.exp(-tau / np.sqrt(1 - (1 - cos_i**2) / n**2))
    loop = (1 - f) ** 2 * tint**2 * a / (1 - f * f * a * a)
    return f + loop * f * a, loop


def slab(tau, albedo, g, n):
    """An entry of the table of slabs: (R, T) at normal incidence and at cosine 0.6."""
    for row in TABLES["slabs"]:
        if row["key"] == [tau, albedo, g, n]:
            return row
    raise KeyError((tau, albedo, g, n))


def sphere(radius, albedo, g, n):
    """(reflected, standard error) of a sphere in a uniform environment."""
    for row in TABLES["spheres"]:
        if row["key"] == [radius, albedo, g, n]:
            return row["reflected"], row["standard_error"]
    raise KeyError((radius, albedo, g, n))


def simulate(tau, albedo, g=0.0, n=1.0, cos_i=1.0, leave=True, enter=True, isotropic_cosine=True, photons=20_000):
    """(R, T, reflected by the first surface) of a slab, with mistakes on request.

    `leave=False`: what meets the boundary from inside leaves, unless it is reflected totally (no Fresnel on the way out).
    `enter=False`: all light goes in (no Fresnel on the way in).
    """
    rng = np.random.default_rng(7)
    first = float(fresnel(cos_i, n)) if enter else 0.0
    cos = np.full(photons, -np.sqrt(1 - (1 - cos_i**2) / n**2))
    z, weight = np.zeros(photons), np.ones(photons)
    out = [0.0, 0.0]
    while len(z):
        step = -np.log(1 - rng.random(len(z)))
        z = z + cos * step
        while True:
            above, below = z > 0, z < -tau
            met = np.flatnonzero(above | below)
            if not len(met):
                break
            sin2 = (1 - cos[met] ** 2) * n * n
            cos_o = np.sqrt(np.maximum(0.0, 1 - sin2))
            f = np.where(sin2 >= 1, 1.0, fresnel(np.maximum(cos_o, 1e-9), n) if leave else 0.0)
            gone = rng.random(len(met)) >= f
            out[0] += weight[met[gone & above[met]]].sum()
            out[1] += weight[met[gone & below[met]]].sum()
            stay = met[~gone]
            z[stay] = np.where(above[stay], -z[stay], -2 * tau - z[stay])
            cos[stay] = -cos[stay]
            keep = np.ones(len(z), bool)
            keep[met[gone]] = False
            z, cos, weight = z[keep], cos[keep], weight[keep]
        weight = weight * albedo
        low = weight < 0.05
        lives = ~low | (rng.random(len(weight)) < 0.5)
        z, cos, weight = z[lives], cos[lives], np.where(low, 2 * weight, weight)[lives]
        u = rng.random(len(z))
        if g:
            s = (1 - g * g) / (1 - g + 2 * g * u)
            turn = (1 + g * g - s * s) / (2 * g)
        else:
            turn = 2 * u - 1
        phi = 2 * np.pi * rng.random(len(z))
        cos = turn * cos + np.sqrt(np.maximum(0.0, (1 - turn**2) * (1 - cos**2))) * np.cos(phi)
        cos = np.where(np.abs(cos) < 1e-9, 1e-9, cos)
    r, t = (o / photons * (1 - first) for o in out)
    return r + first, t, first
