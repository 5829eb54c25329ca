#!/usr/bin/env python3
"""Cost of a sample as meshes grow: processor seconds a sample a pixel, beside the logarithm of the triangles.

usage: growth.py [-k 5] [--spp 9] [--grids 41,204,645]

Renders the bumpy marble sphere of first_picture.py with 12 n^2 triangles for each n, in turn, with --spp samples and with
one, so that what is done once (the build, cells of the distance bound) does not count. Prints medians. Needs numpy.
"""
import argparse, json, math, pathlib, statistics, subprocess, tempfile

from first_picture import NEPHRITE, write_glb


def seconds(scene, spp, folder):
    stats = folder / "stats.json"
    subprocess.run([NEPHRITE, "render", str(scene), "-o", str(folder / "o.exr"), "--size", "480x270", "--quiet", "--spp", str(spp),
                    "--stats", str(stats)], check=True)
    return json.loads(stats.read_text())["render_cpu_seconds"]


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("-k", type=int, default=5)
    p.add_argument("--spp", type=int, default=9)
    p.add_argument("--grids", default="41,204,645")
    a = p.parse_args()
    grids = [int(n) for n in a.grids.split(",")]
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        scenes = {n: folder / f"{n}.glb" for n in grids}
        for n, scene in scenes.items():
            write_glb(scene, n)
        costs = {n: [] for n in grids}
        for _ in range(a.k):
            for n, scene in scenes.items():
                costs[n].append((seconds(scene, a.spp, folder) - seconds(scene, 1, folder)) / (a.spp - 1))
        first = statistics.median(costs[grids[0]])
        print("| triangles | processor seconds a sample a pixel | times as long | log(triangles), times as large |\n| --- | --- | --- | --- |")
        for n in grids:
            cost = statistics.median(costs[n])
            growth = math.log(12 * n * n) / math.log(12 * grids[0] ** 2)
            print(f"| {12 * n * n} | {cost:.3f} | {cost / first:.2f} | {growth:.2f} |")


if __name__ == "__main__":
    main()
