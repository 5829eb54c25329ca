#!/usr/bin/env python3
"""Agreement of nephrite with converged pictures of another renderer: channel means, and the difference as a picture.

usage: agreement.py --peers DIR [--scenes a,b] [--spp N] [--microfacet single] [--out FOLDER]

DIR as in efficiency.py. For each scene: the mean of each channel of both pictures with standard errors (nephrite's from
four independent seeds; the reference's from its two halves), their ratio, and the largest |z| over 8×8 blocks. Writes
NAME.png: nephrite, reference, and the signed difference of 4×4 blocks (red: nephrite brighter, blue: darker; full
saturation at 10 % of the picture's mean).
"""
import argparse, json, os, tempfile

import numpy as np
from PIL import Image

from efficiency import nephrite, read_exr


def blocks(image, n):
    h, w = image.shape[0] // n * n, image.shape[1] // n * n
    return image[:h, :w].reshape(h // n, n, w // n, n, 3).mean((1, 3))


def display(image):
    x = np.clip(image, 0, None)
    x = np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.power(x, 1 / 2.4) - 0.055)
    return (np.clip(x, 0, 1) * 255 + 0.5).astype(np.uint8)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--peers", required=True)
    p.add_argument("--scenes")
    p.add_argument("--spp", type=int, default=256)
    p.add_argument("--microfacet", default="single")
    p.add_argument("--reference", default="mitsuba")
    p.add_argument("--out", default="out/agreement")
    a = p.parse_args()
    os.makedirs(a.out, exist_ok=True)
    scenes = a.scenes.split(",") if a.scenes else sorted(s for s in os.listdir(f"{a.peers}/ref"))
    for scene in scenes:
        path = f"{a.peers}/ref/{scene}/{a.reference}"
        if not os.path.exists(path + ".exr"):
            continue
        ref, half_a, half_b = (read_exr(path + s + ".exr") for s in ("", "_A", "_B"))
        with tempfile.TemporaryDirectory() as tmp:
            images = []
            for seed in range(1, 5):
                nephrite(a.peers, scene, max(1, a.spp // 4), seed, f"{tmp}/n.exr", ["--microfacet", a.microfacet])
                images.append(read_exr(f"{tmp}/n.exr"))
        ours = np.mean(images, 0)
        se_ours = np.std([i.mean((0, 1)) for i in images], 0, ddof=1) / 2
        se_ref = np.abs(half_a.mean((0, 1)) - half_b.mean((0, 1))) / 2
        ratio = ours.mean((0, 1)) / ref.mean((0, 1)) - 1
        var = np.var([blocks(i, 8) for i in images], 0, ddof=1) / 4 + (blocks(half_a, 8) - blocks(half_b, 8)) ** 2 / 4
        scale = np.sqrt(var + (1e-3 * ref.mean()) ** 2 + np.median(var))
        z = (blocks(ours, 8) - blocks(ref, 8)) / scale
        print(f"{scene:16s} mean {ours.mean((0, 1)).round(5)} ± {se_ours.round(5)}  reference {ref.mean((0, 1)).round(5)} ± {se_ref.round(5)}"
              f"  ratio-1 {np.array2string(100 * ratio, precision=2)} %  block z: rms {np.sqrt((z**2).mean()):.2f} max {np.abs(z).max():.1f}", flush=True)
        d = (blocks(ours, 4) - blocks(ref, 4)).mean(-1) / (0.1 * ref.mean())
        false = np.stack([1 + np.minimum(d, 0), 1 - np.abs(d), 1 - np.maximum(d, 0)], -1).clip(0, 1)
        false = np.kron(false, np.ones((4, 4, 1)))
        h, w = false.shape[:2]
        gain = 0.4 / max(ref.mean(), 1e-6)
        sheet = np.concatenate([display(ours[:h, :w] * gain), display(ref[:h, :w] * gain), (false * 255).astype(np.uint8)], 1)
        Image.fromarray(sheet).save(f"{a.out}/{scene}.png")


if __name__ == "__main__":
    main()
