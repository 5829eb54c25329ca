#!/usr/bin/env python3
"""Parallel efficiency of two threads, or more: T1 / (n Tn), medians of interleaved renders.

usage: scaling.py --peers DIR [--scene marble-suzanne] [--spp 16] [--threads 2] [-k 5]
       scaling.py --file model.glb [--size 640x480]

Times are `render_seconds` of --stats: the pixels, without loading, building and writing. The pictures must be the same. Nothing
else may run on the machine.
"""
import argparse, hashlib, json, os, statistics, subprocess, tempfile

from efficiency import environment

NEPHRITE = os.environ.get("NEPHRITE", "target/release/nephrite")


def scene_of(peers, name):
    folder = f"{peers}/scenes/{name}"
    info = json.load(open(f"{folder}/scene.json"))
    return [f"{folder}/{info['file']}", "--size", f"{info['width']}x{info['height']}", *environment(folder, info["env"])]


def render(arguments, threads, folder):
    picture, stats = f"{folder}/{threads}.exr", f"{folder}/{threads}.json"
    subprocess.run([NEPHRITE, "render", *arguments, "-o", picture, "--float", "--threads", str(threads), "--quiet", "--stats", stats],
                   check=True)
    digest = hashlib.sha256(open(picture, "rb").read()).hexdigest()
    return json.load(open(stats))["render_seconds"], digest


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--peers")
    p.add_argument("--scene", default="marble-suzanne")
    p.add_argument("--file")
    p.add_argument("--size", default="640x480")
    p.add_argument("--spp", type=int, default=16)
    p.add_argument("--threads", type=int, default=2)
    p.add_argument("-k", type=int, default=5)
    a = p.parse_args()
    if not a.file and not a.peers:
        p.error("--peers or --file")
    arguments = [a.file, "--size", a.size] if a.file else scene_of(a.peers, a.scene)
    arguments += ["--spp", str(a.spp)]
    seconds, digests = {1: [], a.threads: []}, set()
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(a.k):
            for threads, found in seconds.items():
                took, digest = render(arguments, threads, folder)
                found.append(took)
                digests.add(digest)
    if len(digests) != 1:
        raise SystemExit("the picture depends on the number of threads")
    one, many = (statistics.median(found) for found in seconds.values())
    pairs = sorted(100 * x / (a.threads * y) for x, y in zip(*seconds.values()))
    print(f"1 thread {one:.3f} s, {a.threads} threads {many:.3f} s, efficiency {100 * one / (a.threads * many):.1f} %; "
          f"of single pairs {pairs[0]:.1f} to {pairs[-1]:.1f} %")


if __name__ == "__main__":
    main()
