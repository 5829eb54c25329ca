"""Cases made of slabs: what comes back from one, what passes through it, and both.

The slab is a hundred times as wide as thick and seen in its middle, so its sides matter less than 1e-4 of the picture. A
uniform sky above a black plate shows the reflectance (by reciprocity that of a beam along the view), a shining plate below a
black sky the transmittance, a sky all around their sum.
"""
import numpy as np

import truth
from case import Case
from document import black, medium, plate, slab

THICKNESS = 0.01
HALF_WIDTH = 1.0
# Beside the noise, what single precision, the finite width of the slab and its 12 triangles may cost.
ROUNDING = 0.003
WHY = "rounding, and the finite width of the slab (less than 0.1 % together), with a margin for single precision."
TABLE = "adding–doubling, error below 1e-6"
CLOSED = "closed form: Fresnel and Beer–Lambert, all internal reflections"
DOWN, OBLIQUE = (0, -1, 0), (0.8, -0.6, 0)


def stage(case, side, thickness=THICKNESS, half_width=HALF_WIDTH, cos=1.0, radiance=1.0, view=None):
    """Light and camera for the `side`: R, T or both."""
    case.side, case.cos = side, cos
    if side in ("R", "both"):
        case.under(radiance)
    if side == "R":
        case.document.add(plate(1.2 * half_width, -1.1 * thickness), black(), "black plate")
    if side == "T":
        case.document.add(plate(1.2 * half_width, -1.1 * thickness), black([radiance] * 3), "shining plate")
    case.document.camera(DOWN if cos == 1.0 else OBLIQUE, view or 0.1 * thickness, (0, 0, 0), 50 * thickness)
    return case


def coefficients(tau, albedo, thickness=THICKNESS):
    """(σa, σs) in 1/m of three channels."""
    tau, albedo = np.broadcast_to(tau, 3).astype(float), np.broadcast_to(albedo, 3).astype(float)
    return tau * (1 - albedo) / thickness, tau * albedo / thickness


def of(case, rt):
    """The side that the case shows, of a pair (R, T)."""
    return {"R": rt[0], "T": rt[1], "both": rt[0] + rt[1]}[case.side]


def tabulated(case, tau, albedo, g, n):
    """The expectation of a scattering slab from the table, and what mistakes would show."""
    tau, albedo = (list(np.broadcast_to(v, 3)) for v in (tau, albedo))
    tau = [int(t) if t == int(t) else float(t) for t in tau]
    albedo = [float(a) for a in albedo]
    key = "normal" if case.cos == 1.0 else "oblique"
    look = lambda g, n: [of(case, truth.slab(t, a, g, n)[key]) for t, a in zip(tau, albedo)]
    expect = case.expect("the slab", look(g, n), TABLE, ROUNDING, WHY)
    return mistakes(case, expect, tau, albedo, g, n)


def mistakes(case, expect, tau, albedo, g, n):
    """What usual mistakes in the transport through a slab would show."""
    tau, albedo = np.broadcast_to(tau, 3).astype(float), np.broadcast_to(albedo, 3).astype(float)

    def seen(tau=tau, albedo=albedo, g=g, n=n, **wrong):
        return np.array([of(case, truth.simulate(t, a, g, n, case.cos, **wrong)) for t, a in zip(tau, albedo)])

    f = truth.fresnel(case.cos, n) if case.side != "T" else 0.0
    expect.symptom(seen(2 * tau), "coefficients are twice too large (a diameter taken for a radius, or a unit wrong by 2)")
    expect.symptom(seen(tau / 2), "coefficients are half of what they should be")
    expect.symptom(seen(tau * albedo, np.ones(3)), "absorption is ignored: only the scattering coefficient counts")
    expect.symptom(seen(tau * albedo, albedo), "the scattering coefficient is taken for extinction: σt = σs instead of σa + σs")
    if not np.all(albedo == 1):
        expect.symptom(seen(tau * (2 - albedo), albedo / (2 - albedo)), "absorption counts twice: once on the way and once in the albedo")
    if g:
        expect.symptom(seen(g=-g), "the sign of g is flipped: directions point to the wrong side of the event")
        expect.symptom(seen(g=0.0), "g is ignored: scattering is isotropic")
        reduced = tau * albedo * (1 - g)
        total = tau * (1 - albedo) + reduced
        expect.symptom(seen(total, reduced / total, 0.0), "similarity: the coefficient was reduced by 1 − g, and scattering is isotropic")
    if n != 1:
        expect.symptom(seen(leave=False), "no Fresnel reflection inside: light that meets the boundary from inside leaves, unless it is reflected totally")
        expect.symptom(seen(enter=False), "no Fresnel reflection outside: all light goes in")
        expect.symptom(seen(n=1.0), "the boundary is not there: index 1")
        unscaled(expect, f, n)
    return expect


def unscaled(expect, mirrored, n):
    """What is seen of light that went in and out if one of the crossings scales radiance wrongly; `mirrored` did not go in."""
    right = np.asarray(expect.mean)
    for name, factor in (("η²", n**2), ("1/η²", n**-2)):
        expect.symptom(mirrored + (right - mirrored) * factor, f"{name} too much: radiance is scaled at one crossing and not scaled back at the other")
    for name, factor in (("η", n), ("1/η", 1 / n)):
        expect.symptom(mirrored + (right - mirrored) * factor, f"{name} too much: radiance is scaled by η² at one crossing and by η at the other")


def scattering(name, title, tests, text, tau, albedo, g, n, side="R", cos=1.0, spp=1024, sweep=None, **material):
    """One slab of a tabulated medium."""
    case = stage(Case(name, title, tests, text, spp=spp, sweep=sweep), side, cos=cos)
    a, s = coefficients(tau, albedo)
    case.document.add(slab(THICKNESS, HALF_WIDTH), medium(a, s, g, n, **material), "slab")
    tabulated(case, tau, albedo, g, n)
    return case


def absorbing(name, title, tests, text, tau, n, cos=1.0, spp=256, sweep=None, side="both"):
    """One slab that only absorbs."""
    case = stage(Case(name, title, tests, text, spp=spp, sweep=sweep), side, cos=cos)
    case.document.add(slab(THICKNESS, HALF_WIDTH), medium(np.asarray(tau) / THICKNESS, ior=n), "slab")
    seen = lambda tau, n=n, cos=cos: of(case, truth.clear(np.asarray(tau, float), n, cos))
    expect = case.expect("the slab", list(seen(tau)), CLOSED, ROUNDING, WHY)
    absorbed(expect, seen, np.asarray(tau, float), n, cos)
    return case


def absorbed(expect, seen, tau, n, cos):
    """What usual mistakes of absorption would show."""
    expect.symptom(seen(2 * tau), "the way is taken twice as long, or the coefficient twice as large")
    expect.symptom(seen(tau / 2), "the coefficient is half of what it should be")
    expect.symptom(seen(0 * tau), "absorption is ignored")
    expect.symptom(np.exp(-tau / np.sqrt(1 - (1 - cos**2) / n**2)), "no Fresnel reflection: Beer–Lambert only")
    f = truth.fresnel(cos, n)
    inside = np.exp(-tau / np.sqrt(1 - (1 - cos**2) / n**2))
    expect.symptom((1 - f) ** 2 * inside + f, "no reflection inside: light leaves at the first crossing")
    unscaled(expect, f, n)
    if cos != 1:
        straight = np.exp(-tau / cos)
        expect.symptom(f + (1 - f) ** 2 * straight / (1 - f * straight), "no refraction: the way inside runs along the ray outside")
    return expect
