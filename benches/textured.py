#!/usr/bin/env python3
"""Textured models beside Cycles: the same file, camera and environment, and the difference as a picture.

usage: textured.py --env FILE.exr [--spp N] [--size N] [--out FOLDER] MODEL.glb...

Each .glb gets a camera that looks at it, in a copy that both programs read: nephrite as it is, Cycles through Blender's own
importer. Prints the mean of each channel of both pictures where the model is, the ratio less 1, and the root mean square of
the difference of 8 x 8 blocks; writes NAME.png: nephrite, Cycles, and the signed difference of 4 x 4 blocks (red: nephrite
brighter, blue: darker; full color at 20 % of the picture's mean). Needs numpy, Pillow, OpenEXR and bpy from PyPI.
"""
import argparse, json, os, struct, subprocess, sys, tempfile

import numpy as np
from PIL import Image

from agreement import blocks, display
from efficiency import ROOT, read_exr

# As Blender's importer turns glTF's axes, its equirectangular map is glTF's; see the peers.
CYCLES = """
import os, sys, bpy
model, env, size, spp, out = sys.argv[1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=model, export_import_convert_lighting_mode='COMPAT')
scene = bpy.context.scene
scene.camera = next(o for o in scene.objects if o.type == 'CAMERA' and o.name.startswith('bench-camera'))
world = bpy.data.worlds.new('world')
scene.world, world.use_nodes = world, True
image = world.node_tree.nodes.new('ShaderNodeTexEnvironment')
image.image = bpy.data.images.load(os.path.abspath(env))
image.image.colorspace_settings.name = 'Non-Color'
world.node_tree.links.new(image.outputs[0], world.node_tree.nodes['Background'].inputs['Color'])
r, c = scene.render, scene.cycles
r.engine, r.resolution_x, r.resolution_y, r.resolution_percentage = 'CYCLES', int(size), int(size), 100
r.threads_mode, r.threads, r.use_compositing = 'FIXED', 2, False
r.image_settings.file_format, r.image_settings.color_depth, r.image_settings.color_mode = 'OPEN_EXR', '32', 'RGB'
scene.view_settings.view_transform = 'Raw'
r.filepath = out
c.device, c.samples, c.use_adaptive_sampling, c.use_denoising = 'CPU', int(spp), False, False
c.sample_clamp_direct = c.sample_clamp_indirect = c.blur_glossy = c.light_sampling_threshold = 0
c.max_bounces = c.diffuse_bounces = c.glossy_bounces = c.transmission_bounces = c.transparent_max_bounces = 64
c.pixel_filter_type = 'BOX'
bpy.ops.render.render(write_still=True)
"""


def matrix(node):
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    m = np.eye(4)
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    m[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                 [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                 [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    m[:3, :3] *= np.array(node.get("scale", [1, 1, 1]))
    m[:3, 3] = node.get("translation", [0, 0, 0])
    return m


def bounds(document):
    """Corners of the scene, from those that accessors state."""
    corners = []

    def visit(index, world):
        node = document["nodes"][index]
        world = world @ matrix(node)
        if "mesh" in node:
            for primitive in document["meshes"][node["mesh"]]["primitives"]:
                accessor = document["accessors"][primitive["attributes"]["POSITION"]]
                low, high = accessor["min"], accessor["max"]
                for i in range(8):
                    corner = [high[k] if i >> k & 1 else low[k] for k in range(3)] + [1]
                    corners.append((world @ corner)[:3])
        for child in node.get("children", []):
            visit(child, world)

    for root in document["scenes"][document.get("scene", 0)]["nodes"]:
        visit(root, np.eye(4))
    return np.min(corners, 0), np.max(corners, 0)


def with_camera(path, out):
    """A copy of a .glb with a camera that sees all of it from the front, a little to the right and above."""
    data = open(path, "rb").read()
    size = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20 : 20 + size])
    low, high = bounds(document)
    center, radius = (low + high) / 2, np.linalg.norm(high - low) / 2
    z = np.array([0.35, 0.25, 1.0])
    z /= np.linalg.norm(z)
    x = np.cross([0, 1, 0], z)
    x /= np.linalg.norm(x)
    pose = np.eye(4)
    pose[:3, 0], pose[:3, 1], pose[:3, 2], pose[:3, 3] = x, np.cross(z, x), z, center + z * radius * 3.4
    document["cameras"] = [{"type": "perspective", "perspective": {
        "yfov": 0.6, "aspectRatio": 1.0, "znear": radius * 0.01, "zfar": radius * 100}}]
    for node in document["nodes"]:
        node.pop("camera", None)
    document["nodes"].append({"name": "bench-camera", "camera": 0, "matrix": pose.T.ravel().tolist()})
    document["scenes"][document.get("scene", 0)]["nodes"].append(len(document["nodes"]) - 1)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + size :]
    with open(out, "wb") as f:
        f.write(b"glTF" + struct.pack("<III", 2, 20 + len(text) + len(rest), len(text)) + b"JSON" + text + rest)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("models", nargs="+")
    p.add_argument("--env", required=True)
    p.add_argument("--spp", type=int, default=128)
    p.add_argument("--size", type=int, default=400)
    p.add_argument("--out", default="out/textured")
    p.add_argument("--options", default="", help="further options of nephrite")
    a = p.parse_args()
    os.makedirs(a.out, exist_ok=True)
    for model in a.models:
        name = os.path.splitext(os.path.basename(model))[0]
        with tempfile.TemporaryDirectory() as tmp:
            glb, ours, theirs, mask = (f"{tmp}/{f}" for f in ("m.glb", "n.exr", "c.exr", "mask.exr"))
            with_camera(model, glb)
            command = [f"{ROOT}/target/release/nephrite", "render", glb, "--float", "--quiet", "--size", f"{a.size}x{a.size}",
                       "--camera", "bench-camera", "--threads", "2"]
            light = ["--spp", str(a.spp), "--env", a.env, *a.options.split()]
            subprocess.run([*command, "-o", ours, *light], check=True)
            # The background alone is black in a render without light, and so is nothing else in a white furnace.
            subprocess.run([*command, "-o", mask, "--spp", "4", "--env", "1,1,1", "--transparent-background"], check=True)
            run = subprocess.run([sys.executable, "-c", CYCLES, glb, a.env, str(a.size), str(a.spp), theirs],
                                 capture_output=True, text=True)
            if not os.path.exists(theirs):
                sys.exit(run.stdout[-2000:] + run.stderr[-2000:])
            ours, theirs, inside = read_exr(ours), read_exr(theirs), read_exr(mask).sum(-1) > 1e-3
        mean = [image[inside].mean(0) for image in (ours, theirs)]
        d8 = blocks(ours, 8) - blocks(theirs, 8)
        covered = blocks(np.repeat(inside[..., None], 3, 2).astype(float), 8)[..., 0] > 0.99
        rms = np.sqrt((d8[covered] ** 2).mean()) / theirs[inside].mean()
        ratio = 100 * (mean[0] / mean[1] - 1)
        print(f"{name}: nephrite {mean[0].round(4)}, Cycles {mean[1].round(4)}, ratio less 1 {ratio.round(2)} %, blocks differ by "
              f"{100 * rms:.1f} % rms", flush=True)
        d = (blocks(ours, 4) - blocks(theirs, 4)).mean(-1) / (0.2 * theirs[inside].mean())
        false = np.stack([1 + np.minimum(d, 0), 1 - np.abs(d), 1 - np.maximum(d, 0)], -1).clip(0, 1)
        false = np.kron(false, np.ones((4, 4, 1)))
        h, w = false.shape[:2]
        gain = 0.4 / max(theirs[inside].mean(), 1e-6)
        sheet = [display(ours[:h, :w] * gain), display(theirs[:h, :w] * gain), (false * 255).astype(np.uint8)]
        Image.fromarray(np.concatenate(sheet, 1)).save(f"{a.out}/{name}.png")


if __name__ == "__main__":
    main()
