#!/usr/bin/env python3
"""Time to the first picture: from the start of the program to the first pass on disk.

usage: first_picture.py [-k N] [--folder FOLDER] [--threads N] [--option=...]

Writes a bumpy sphere of 499,392 triangles with NEPHRITE_materials_subsurface (a marble) as a .glb of 9 MB with a camera, and
renders it in 480 x 270 pixels N times. The first picture is there when the output appears; the program is then stopped. The
last run goes on to its end, for the statistics of loading and building. Needs numpy.
"""
import argparse, json, os, pathlib, signal, statistics, struct, subprocess, tempfile, time

GRID = 204
NEPHRITE = os.environ.get("NEPHRITE", "target/release/nephrite")


def bumpy_sphere(n):
    """A cube's six grids of n x n squares, pushed onto a sphere with waves: 12 n^2 triangles, closed."""
    import numpy as np

    i = np.arange(n + 1)
    a, b = np.meshgrid(2 * i - n, 2 * i - n)
    full = np.full_like(a, n)
    faces = [(full, a, b), (-full, b, a), (b, full, a), (a, -full, b), (a, b, full), (b, a, -full)]
    p = np.concatenate([np.stack(face, -1).reshape(-1, 3) for face in faces]).astype(np.float64)
    p /= np.linalg.norm(p, axis=-1, keepdims=True)
    wave = np.sin(9 * p[:, :1]) * np.sin(11 * p[:, 1:2]) * np.sin(10 * p[:, 2:])
    at = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]
    one = np.stack([np.stack([a, b, c], -1), np.stack([b, d, c], -1)], 2).reshape(-1, 3)
    triangles = np.concatenate([one + face * (n + 1) ** 2 for face in range(6)])
    return (p * (1 + 0.2 * wave)).astype("<f4"), triangles.astype("<u4")


def write_glb(path, grid=GRID):
    positions, triangles = bumpy_sphere(grid)
    binary = positions.tobytes() + triangles.tobytes()
    views = [{"buffer": 0, "byteOffset": 0, "byteLength": positions.nbytes},
             {"buffer": 0, "byteOffset": positions.nbytes, "byteLength": triangles.nbytes}]
    document = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["NEPHRITE_materials_subsurface"],
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 4.5]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.1}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(positions), "type": "VEC3",
             "min": positions.min(0).tolist(), "max": positions.max(0).tolist()},
            {"bufferView": 1, "componentType": 5125, "count": triangles.size, "type": "SCALAR"},
        ],
        "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.3}, "extensions": {
            "NEPHRITE_materials_subsurface": {"absorptionCoefficient": [0.1, 0.2, 0.35],
                                              "scatteringCoefficient": [110, 131, 150], "ior": 1.5}}}],
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    path.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body)


def first_picture(command, picture, stop):
    """Seconds until the picture is there."""
    picture.unlink(missing_ok=True)
    began = time.perf_counter()
    process = subprocess.Popen(command)
    while not picture.exists() and process.poll() is None:
        time.sleep(0.002)
    seconds = time.perf_counter() - began
    if stop:
        process.kill()
    process.wait()
    return seconds


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("-k", type=int, default=7)
    p.add_argument("--folder", type=pathlib.Path)
    p.add_argument("--threads", type=int, default=2)
    p.add_argument("--option", action="append", default=[], help="a further option for nephrite")
    a = p.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = a.folder or pathlib.Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        scene, picture, stats = folder / "half-million.glb", folder / "first.png", folder / "first.json"
        write_glb(scene)
        command = [NEPHRITE, "render", str(scene), "-o", str(picture), "--size", "480x270", "--threads", str(a.threads), "--quiet",
                   "--progressive", "--stats", str(stats), *a.option]
        found = sorted(first_picture(command, picture, True) for _ in range(a.k))
        first_picture([*command, "--spp", "1"], picture, False)
        s = json.loads(stats.read_text())
        print(f"first picture {statistics.median(found):.2f} s, median of {a.k} ({found[0]:.2f} to {found[-1]:.2f}); "
              f"of the last run: load {s['load_seconds']:.2f} s, build {s['build_seconds']:.2f} s, "
              f"one sample a pixel {s['render_seconds']:.2f} s, write {s['write_seconds']:.3f} s")


if __name__ == "__main__":
    main()
