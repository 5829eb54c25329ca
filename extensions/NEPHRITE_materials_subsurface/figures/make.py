"""Writes seen-albedo.svg: what an albedo of a medium looks like under boundaries of several indices.

    python3 extensions/NEPHRITE_materials_subsurface/figures/make.py

Photons walk in a half-space without absorption under a smooth boundary, lit by uniform diffuse light (isotropic
scattering). If p_n is the share that leaves after n scattering events, the reflectance for a single-scattering albedo a
is the sum of p_n a^n, for all a at once. The dots are values of test-vectors.json, computed by adding-doubling.
"""
import json
import os

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
PHOTONS, ORDERS = 200_000, 4000


def fresnel(cosine, eta):
    """Unpolarised reflectance from inside (eta = inside over outside) for the cosine inside."""
    sine2 = eta**2 * (1 - cosine**2)
    other = np.sqrt(np.clip(1 - sine2, 0, 1))
    s = (eta * cosine - other) / (eta * cosine + other)
    p = (cosine - eta * other) / (cosine + eta * other)
    return np.where(sine2 >= 1, 1.0, (s * s + p * p) / 2)


def orders(eta, seed=1):
    """p_n for n < ORDERS; p_0 is the reflection at the surface."""
    random = np.random.default_rng(seed)
    outside = np.sqrt(random.random(PHOTONS))
    inside = np.sqrt(1 - (1 - outside**2) / eta**2)
    entered = random.random(PHOTONS) >= fresnel(inside, eta)
    share = np.zeros(ORDERS)
    share[0] = np.mean(~entered)
    cosine = inside[entered]                       # downwards positive
    depth = np.zeros(len(cosine))
    for n in range(1, ORDERS):
        depth = depth - np.log1p(-random.random(len(depth))) * cosine
        while True:
            out = depth < 0
            if not out.any():
                break
            back = fresnel(-cosine[out], eta) > random.random(out.sum())
            gone = np.flatnonzero(out)[~back]
            share[n - 1] += len(gone) / PHOTONS if n > 1 else 0
            turned = np.flatnonzero(out)[back]
            depth[turned] *= -1
            cosine[turned] *= -1
            depth, cosine = np.delete(depth, gone), np.delete(cosine, gone)
        cosine = 2 * random.random(len(depth)) - 1
    return share


def single(multiple):
    s = 4.09712 + 4.20863 * multiple - np.sqrt(9.59217 + 41.6808 * multiple + 17.7126 * multiple**2)
    return np.clip(1 - s * s, 0, 1)


def multiple(single):
    s = np.sqrt(1 - single)
    return (1 - s) * (1 - 0.139 * s) / (1 + 1.17 * s)


def main():
    cases = json.load(open(os.path.join(HERE, "..", "test-vectors.json")))["halfSpace"]["cases"]
    size, left, top = 360, 60, 24
    place = lambda x, y: f"{left + size * x:.1f},{top + size * (1 - y):.1f}"
    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {left + size + 110} {top + size + 56}" font-family="sans-serif" font-size="13">',
           '<rect width="100%" height="100%" fill="#fff"/>']
    for i in range(6):
        v = i / 5
        (x0, y0), (x1, y1) = place(v, 0).split(","), place(0, v).split(",")
        svg.append(f'<path d="M{place(v, 0)} L{place(v, 1)} M{place(0, v)} L{place(1, v)}" stroke="#ddd"/>')
        svg.append(f'<text x="{x0}" y="{float(y0) + 18}" text-anchor="middle">{v:.1f}</text><text x="{float(x1) - 8}" y="{float(y1) + 4}" text-anchor="end">{v:.1f}</text>')
    rho = np.linspace(0, 0.96, 97)
    for eta, color in ((1.0, "#888"), (1.33, "#2a7fb8"), (1.5, "#1c8a5a")):
        share = orders(eta)
        reflectance = lambda a: float(np.polynomial.polynomial.polyval(a, share))
        curve = [place(r, reflectance(single(r))) for r in rho]
        svg.append(f'<path d="M{" L".join(curve)}" fill="none" stroke="{color}" stroke-width="2"/>')
        for case in cases:
            if case["ior"] == eta and case["g"] == 0:
                x, y = place(multiple(case["albedo"]), case["diffuse"]).split(",")
                svg.append(f'<circle cx="{x}" cy="{y}" r="3.5" fill="{color}"/>')
                print(eta, case["albedo"], "walk", round(reflectance(case["albedo"]), 4), "adding-doubling", case["diffuse"])
        x, y = (float(v) for v in curve[-1].split(","))
        svg.append(f'<text x="{x + 14}" y="{y + {1.0: -4, 1.33: 8, 1.5: 20}[eta]}" fill="{color}">index {eta:g}</text>')
    svg.append(f'<text x="{left + size / 2}" y="{top + size + 42}" text-anchor="middle">multi-scatter albedo ρ of the medium</text>')
    svg.append(f'<text transform="translate(18 {top + size / 2}) rotate(-90)" text-anchor="middle">reflectance seen (diffuse light, with reflection)</text>')
    with open(os.path.join(HERE, "seen-albedo.svg"), "w", encoding="utf-8") as file:
        file.write("\n".join(svg) + "\n</svg>\n")


if __name__ == "__main__":
    main()
