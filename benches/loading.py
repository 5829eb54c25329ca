#!/usr/bin/env python3
"""Loading speed: a mesh of a million triangles with 4K textures from one .glb, beside Mitsuba and Blender.

usage: loading.py make FOLDER       writes loading-jpeg.glb, loading-png.glb and the same data for Mitsuba
       loading.py run FOLDER [-k N] times nephrite, Mitsuba and Blender in turn, N times each

The mesh is a bumpy torus with normals and texture coordinates, 500,000 vertices and a million triangles with indices of 32
bits. Base color, metalness with roughness, and normals are 4096 x 4096 pixels of noise with grain, as JPEG of quality 90 or
PNG. The file has no tangents, so they are computed. Needs numpy and Pillow; `run` times those of `mitsuba` and `bpy` that
are installed, each in a process of its own with the clock of the process started after its imports.
"""
import argparse, io, json, os, pathlib, statistics, struct, subprocess, sys, time

ROWS, COLUMNS, SIDE = 500, 1000, 4096
NEPHRITE = os.environ.get("NEPHRITE", "target/release/nephrite")


def torus():
    import numpy as np

    u, v = np.meshgrid(np.linspace(0, 1, COLUMNS + 1), np.linspace(0, 1, ROWS + 1))
    a, b = 2 * np.pi * u, 2 * np.pi * v
    r = 0.3 + 0.02 * np.sin(20 * a) * np.sin(8 * b)
    p = np.stack([(1 + r * np.cos(b)) * np.cos(a), r * np.sin(b), (1 + r * np.cos(b)) * np.sin(a)], -1)
    # Differences wrap around, so that normals agree along the seam of the texture.
    ring = p[:-1, :-1]
    along = np.roll(ring, -1, 1) - np.roll(ring, 1, 1)
    across = np.roll(ring, -1, 0) - np.roll(ring, 1, 0)
    n = np.cross(across, along)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    n = np.pad(n, ((0, 1), (0, 1), (0, 0)), "wrap")
    i = np.arange((ROWS + 1) * (COLUMNS + 1), dtype=np.uint32).reshape(ROWS + 1, COLUMNS + 1)
    a, b, c, d = i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]
    triangles = np.stack([np.stack([a, d, c], -1), np.stack([a, c, b], -1)], 2).reshape(-1, 3)
    flat = lambda x: np.ascontiguousarray(x.reshape(-1, x.shape[-1]), np.float32)
    return flat(p), flat(n), flat(np.stack([u, v], -1)), triangles


def noise(seed):
    """Octaves of smooth noise and some grain in [0, 1]."""
    import numpy as np
    from PIL import Image

    rng = np.random.default_rng(seed)
    total = np.zeros((SIDE, SIDE), np.float32)
    for octave in range(2, 11):
        small = Image.fromarray(rng.random((1 << octave, 1 << octave), np.float32))
        total += np.asarray(small.resize((SIDE, SIDE), Image.BICUBIC)) * 0.7**octave
    total += 0.01 * rng.random((SIDE, SIDE), np.float32)
    return (total - total.min()) / (total.max() - total.min())


def textures():
    import numpy as np
    from PIL import Image

    to8 = lambda *c: Image.fromarray((255 * np.clip(np.stack(c, -1), 0, 1) + 0.5).astype(np.uint8))
    a, b = noise(1), noise(2)
    slope = [SIDE / 40 * (np.roll(a, 1, axis) - np.roll(a, -1, axis)) for axis in (1, 0)]
    z = 1 / np.sqrt(1 + slope[0] ** 2 + slope[1] ** 2)
    return {
        "color": to8(0.2 + 0.6 * a, 0.3 + 0.5 * b, 0.5 - 0.3 * a * b),
        "roughness": to8(np.ones_like(a), 0.2 + 0.6 * b, np.zeros_like(a)),
        "normal": to8(0.5 + 0.5 * slope[0] * z, 0.5 + 0.5 * slope[1] * z, 0.5 + 0.5 * z),
    }


def make(folder):
    import numpy as np

    folder.mkdir(parents=True, exist_ok=True)
    positions, normals, uvs, triangles = torus()
    images = textures()
    for kind in ("jpeg", "png"):
        binary, views = b"", []

        def view(data, **more):
            nonlocal binary
            views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data), **more})
            binary += data + b"\0" * (-len(data) % 4)
            return len(views) - 1

        for array in (positions, normals, uvs):
            view(array.tobytes(), target=34962)
        view(triangles.astype("<u4").tobytes(), target=34963)
        for name, image in images.items():
            out = io.BytesIO()
            image.save(out, kind, quality=90)
            (folder / f"{name}.{kind}").write_bytes(out.getvalue())
            view(out.getvalue())
        count = len(positions)
        document = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0}]}],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3",
                 "min": positions.min(0).tolist(), "max": positions.max(0).tolist()},
                {"bufferView": 1, "componentType": 5126, "count": count, "type": "VEC3"},
                {"bufferView": 2, "componentType": 5126, "count": count, "type": "VEC2"},
                {"bufferView": 3, "componentType": 5125, "count": triangles.size, "type": "SCALAR"},
            ],
            "images": [{"bufferView": i, "mimeType": f"image/{kind}"} for i in (4, 5, 6)],
            "textures": [{"source": i} for i in range(3)],
            "materials": [{
                "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 1}},
                "normalTexture": {"index": 2},
            }],
            "bufferViews": views,
            "buffers": [{"byteLength": len(binary)}],
        }
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        body = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
        (folder / f"loading-{kind}.glb").write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body)
    # Mitsuba reads the mesh as binary PLY.
    vertices = np.hstack([positions, normals, uvs]).astype("<f4")
    properties = "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz", "u", "v"))
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n{properties}"
              f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
    faces = np.empty(len(triangles), [("n", "u1"), ("i", "<i4", 3)])
    faces["n"], faces["i"] = 3, triangles
    (folder / "mesh.ply").write_bytes(header.encode() + vertices.tobytes() + faces.tobytes())


def nephrite(folder, kind):
    """Everything up to the first ray: file, images, tangents, acceleration structures."""
    stats = folder / "stats.json"
    command = [NEPHRITE, "render", str(folder / f"loading-{kind}.glb"), "-o", str(folder / "out.png"), "--size", "16x16",
               "--spp", "1", "--threads", "2", "--quiet", "--stats", str(stats)]
    subprocess.run(command, check=True)
    data = json.loads(stats.read_text())
    return data["load_seconds"], data["build_seconds"]


MITSUBA = """
import sys, time, json, mitsuba as mi
folder, kind = sys.argv[1:]
mi.set_variant('llvm_ad_rgb' if len(sys.argv) > 3 else 'scalar_rgb')
t = time.perf_counter()
bitmap = lambda name, raw: {'type': 'bitmap', 'filename': f'{folder}/{name}.{kind}', 'raw': raw}
scene = mi.load_dict({'type': 'scene', 'shape': {'type': 'ply', 'filename': f'{folder}/mesh.ply', 'bsdf': {
    'type': 'normalmap', 'normalmap': bitmap('normal', True), 'bsdf': {'type': 'principled',
    'base_color': bitmap('color', False), 'roughness': bitmap('roughness', True)}}}})
print(json.dumps([time.perf_counter() - t, 0]))
"""

# Cycles builds its own structures when a render begins: `sync` is what it takes until the first sample.
BLENDER = """
import sys, time, json, bpy
folder, kind = sys.argv[1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
t = time.perf_counter()
bpy.ops.import_scene.gltf(filepath=f'{folder}/loading-{kind}.glb')
load = time.perf_counter() - t
scene = bpy.context.scene
scene.render.engine = 'CYCLES'
scene.cycles.samples, scene.cycles.device = 1, 'CPU'
scene.render.resolution_x = scene.render.resolution_y = 16
scene.render.threads_mode, scene.render.threads = 'FIXED', 2
camera = bpy.data.objects.new('camera', bpy.data.cameras.new('camera'))
camera.location = (0, 0, 4)
scene.collection.objects.link(camera)
scene.camera = camera
scene.render.filepath = f'{folder}/blender.png'
t = time.perf_counter()
bpy.ops.render.render(write_still=True)
print(json.dumps([load, time.perf_counter() - t]))
"""


def peer(script, folder, kind):
    run = subprocess.run([sys.executable, "-c", script, str(folder), kind], capture_output=True, text=True)
    if run.returncode != 0:
        return None
    return json.loads(next(line for line in reversed(run.stdout.splitlines()) if line.startswith("[")))


def run(folder, times):
    programs = {"nephrite": nephrite, "mitsuba": lambda *a: peer(MITSUBA, *a), "blender": lambda *a: peer(BLENDER, *a)}
    for kind in ("jpeg", "png"):
        found = {name: [] for name in programs}
        for _ in range(times):
            for name, program in programs.items():
                result = program(folder, kind)
                if result:
                    found[name].append(result)
        for name, results in found.items():
            if results:
                load, build = (statistics.median(r[i] for r in results) for i in (0, 1))
                spread = [f"{sum(r):.2f}" for r in sorted(results, key=sum)]
                print(f"{kind:5} {name:9} load {load:.2f} s, build {build:.2f} s, together {', '.join(spread)} s", flush=True)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("what", choices=["make", "run"])
    p.add_argument("folder", type=pathlib.Path)
    p.add_argument("-k", type=int, default=3)
    a = p.parse_args()
    make(a.folder) if a.what == "make" else run(a.folder, a.k)


main()
