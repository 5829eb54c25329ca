#!/usr/bin/env python3
"""Time to the same noise of each subsurface model, relative to the random walk: interleaved runs, one table.

usage: models.py --peers DIR [--scenes a,b] [--k 4] [--spp 4] [--models a,b,c]

DIR holds `scenes/NAME/{NAME.glb,scene.json}`. K independent pictures of each model; relMSE of one is the mean over pixels
of (variance over the K pictures) / (smoothed mean of the K pictures² + 1 % of its squared mean), with the top 0.1 % of the
pixels dropped. Each model is held against its own mean: bias does not count. The figure is relMSE × median processor
seconds, the ratio that of the random walk over it.
"""
import argparse, json, os, subprocess, tempfile

import numpy as np
from scipy.ndimage import gaussian_filter

from efficiency import ROOT, drop_top, environment, read_exr

MODELS = (
    "dipole,dipole-diffuse,better-dipole,directional-dipole,photon-beam-diffusion,normalized-diffusion,"
    "normalized-diffusion-searchlight,normalized-diffusion-dmfp,brdf-approximation,light-biased"
)


def picture(folder, info, model, spp, seed, out):
    subprocess.run(
        [f"{ROOT}/target/release/nephrite", "render", f"{folder}/{info['file']}", "-o", out, "--float", "--quiet",
         "--size", f"{info['width']}x{info['height']}", "--spp", str(spp), "--seed", str(seed), "--threads", "2",
         "--subsurface", model, "--stats", out + ".json", *environment(folder, info["env"])],
        check=True)
    with open(out + ".json") as stats:
        return read_exr(out), json.load(stats)["render_cpu_seconds"]


def rel_mse(pictures):
    mean = pictures.mean(0)
    smooth = np.stack([gaussian_filter(mean[..., c], 1.5) for c in range(3)], -1)
    return drop_top(pictures.var(0, ddof=1) / (smooth**2 + 0.01 * mean.mean() ** 2))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", required=True)
    parser.add_argument("--scenes", default="marble-suzanne,skimmilk-dragon")
    parser.add_argument("--k", type=int, default=4)
    parser.add_argument("--spp", type=int, default=4)
    parser.add_argument("--models", default=MODELS)
    args = parser.parse_args()
    models = ["random-walk", *args.models.split(",")]
    for scene in args.scenes.split(","):
        folder = f"{args.peers}/scenes/{scene}"
        with open(f"{folder}/scene.json") as text:
            info = json.load(text)
        found = {model: [] for model in models}
        with tempfile.TemporaryDirectory() as temporary:
            for seed in range(1, args.k + 1):
                for model in models:
                    out = os.path.join(temporary, "picture.exr")
                    found[model].append(picture(folder, info, model, args.spp, seed, out))
        walk = None
        for model in models:
            noise = rel_mse(np.stack([p for p, _ in found[model]]))
            seconds = float(np.median([s for _, s in found[model]]))
            walk = walk or noise * seconds
            print(f"{scene:16s} {model:34s} cpu/spp {seconds / args.spp:.4f}  relMSE {noise:.4f}  "
                  f"efficiency {noise * seconds:.4f}  ratio {walk / (noise * seconds):.2f}", flush=True)


if __name__ == "__main__":
    main()
