#!/usr/bin/env python3
"""Efficiency of nephrite beside other renderers: interleaved runs, one table.

usage: efficiency.py --peers DIR [--scenes a,b] [--k 4] [--seconds 6] [--only nephrite,mitsuba-…] [-o result.json]

DIR holds `scenes/NAME/{NAME.glb,scene.json}`, `ref/NAME/mitsuba.exr` and `bin/to_mitsuba.py`, `bin/to_cycles.py`.
For every scene and program, K independent images at a fixed modest number of samples; relMSE of one image is the mean
over pixels of (variance over the K images) / (smoothed reference² + 1 % mean²), with the top 0.1 % of the pixels
dropped; efficiency is relMSE × processor seconds (lower is better); the ratio is the best peer's over nephrite's.
Needs numpy, scipy and OpenEXR from PyPI, and the peers that are to be run.
"""
import argparse, json, os, subprocess, sys, tempfile

import numpy as np
import OpenEXR
from scipy.ndimage import gaussian_filter

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
MITSUBA = {
    f"mitsuba-{variant}-{integrator}": ["to_mitsuba.py", "--variant", variant, "--integrator", integrator]
    for variant in ("scalar_rgb", "llvm_ad_rgb")
    for integrator in ("volpath", "volpathmis")
}
CYCLES = {f"cycles-{mode}": ["to_cycles.py", "--mode", mode] for mode in ("volume", "principled")}


def read_exr(path):
    with OpenEXR.File(path) as f:
        channels = f.channels()
        if "RGB" in channels:
            return channels["RGB"].pixels.astype(np.float64)[..., :3]
        if "RGBA" in channels:
            return channels["RGBA"].pixels.astype(np.float64)[..., :3]
        return np.stack([channels[c].pixels for c in "RGB"], -1).astype(np.float64)


def drop_top(values, fraction=1e-3):
    per_pixel = np.sort(values.mean(-1).ravel())
    return float(per_pixel[: max(1, int(len(per_pixel) * (1 - fraction)))].mean())


def environment(scene_dir, env):
    if env["type"] == "constant":
        return ["--env", ",".join(map(str, env["radiance"]))]
    return ["--env", os.path.join(scene_dir, env["file"]), "--env-intensity", str(env.get("scale", 1.0))]


def nephrite(peers, scene, spp, seed, out, extra):
    folder = f"{peers}/scenes/{scene}"
    info = json.load(open(f"{folder}/scene.json"))
    stats = out + ".json"
    subprocess.run(
        [f"{ROOT}/target/release/nephrite", "render", f"{folder}/{info['file']}", "-o", out, "--float", "--quiet",
         "--size", f"{info['width']}x{info['height']}", "--spp", str(spp), "--seed", str(seed), "--threads", "2",
         "--stats", stats, *environment(folder, info["env"]), *extra],
        check=True)
    s = json.load(open(stats))
    return s["render_cpu_seconds"], s["render_seconds"]


def run(program, peers, scene, spp, seed, out, extra):
    if program.startswith("nephrite"):
        return nephrite(peers, scene, spp, seed, out, extra)
    script, *arguments = {**MITSUBA, **CYCLES}[program]
    r = subprocess.run([sys.executable, f"{peers}/bin/{script}", *arguments, scene, "--spp", str(spp), "--seed", str(seed), "-o", out],
                       capture_output=True, text=True)
    if r.returncode:
        raise SystemExit(r.stdout[-2000:] + r.stderr[-2000:])
    result = json.loads(r.stdout.strip().splitlines()[-1])
    return result["render_cpu_seconds"], result["render_seconds"]


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--peers", required=True)
    p.add_argument("--scenes")
    p.add_argument("--k", type=int, default=4)
    p.add_argument("--seconds", type=float, default=6)
    p.add_argument("--only")
    p.add_argument("--nephrite-options", default="", help="further options for nephrite")
    p.add_argument("-o")
    a = p.parse_args()
    sys.path.insert(0, f"{a.peers}/bin")
    scenes = a.scenes.split(",") if a.scenes else sorted(
        s for s in os.listdir(f"{a.peers}/scenes")
        if os.path.exists(f"{a.peers}/scenes/{s}/scene.json") and s not in ("orientation-check", "furnace-sphere"))
    programs = a.only.split(",") if a.only else ["nephrite", *MITSUBA]
    extra = a.nephrite_options.split()
    results = {}
    for scene in scenes:
        with tempfile.TemporaryDirectory() as tmp:
            spp, images, cpu = {}, {q: [] for q in programs}, {q: [] for q in programs}
            for q in programs:
                seconds = run(q, a.peers, scene, 4, 99, f"{tmp}/t.exr", extra)[0] / 4
                spp[q] = int(min(256, max(4, 2 ** round(np.log2(a.seconds / max(seconds, 1e-3))))))
            for k in range(a.k):
                for q in programs:
                    out = f"{tmp}/{q}.exr"
                    cpu[q].append(run(q, a.peers, scene, spp[q], k + 1, out, extra)[0])
                    images[q].append(read_exr(out))
            path = f"{a.peers}/ref/{scene}/mitsuba.exr"
            rows = {}
            for q in programs:
                stack = np.stack(images[q])
                ref = read_exr(path) if os.path.exists(path) else stack.mean(0)
                smooth = np.stack([gaussian_filter(ref[..., i], 1.5) for i in range(3)], -1)
                relmse = stack.var(0, ddof=1) / (smooth**2 + 0.01 * ref.mean() ** 2)
                rows[q] = dict(spp=spp[q], cpu_seconds_per_spp=float(np.mean(cpu[q]) / spp[q]),
                               relmse=drop_top(relmse), efficiency=drop_top(relmse) * float(np.mean(cpu[q])),
                               mean=[float(v) for v in stack.mean((0, 1, 2))])
            best = {kind: min((rows[q]["efficiency"] for q in rows if q.startswith(kind)), default=None) for kind in ("mitsuba", "cycles-volume", "cycles-principled")}
            for q, r in rows.items():
                print(f"{scene:16s} {q:34s} spp {r['spp']:4d}  cpu/spp {r['cpu_seconds_per_spp']:.4f}  relMSE {r['relmse']:.4g}  efficiency {r['efficiency']:.4g}  mean {' '.join(f'{v:.5f}' for v in r['mean'])}")
            if "nephrite" in rows:
                for kind, e in best.items():
                    if e:
                        print(f"{scene:16s} nephrite is {e / rows['nephrite']['efficiency']:.2f} times as efficient as the best {kind}", flush=True)
            results[scene] = rows
    if a.o:
        json.dump(results, open(a.o, "w"), indent=1)


if __name__ == "__main__":
    main()
