"""Looks at a finished .glb: size, the closedness of what carries a medium, and mean free path against size."""
import json
import os
import struct

import numpy as np

from .gltf_subsurface import NAME

TYPES = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
COUNTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def read(path):
    """The JSON and the binary chunk of a .glb."""
    with open(path, "rb") as file:
        data = file.read()
    (length,) = struct.unpack_from("<I", data, 12)
    return json.loads(data[20:20 + length]), data[28 + length:]


def accessor(document, binary, index):
    entry = document["accessors"][index]
    view = document["bufferViews"][entry["bufferView"]]
    start = view.get("byteOffset", 0) + entry.get("byteOffset", 0)
    count = entry["count"] * COUNTS[entry["type"]]
    return np.frombuffer(binary, TYPES[entry["componentType"]], count, start).reshape(entry["count"], -1)


def matrix(node):
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    rotation = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                         [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                         [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    return rotation * np.array(node.get("scale", (1, 1, 1)))


def closedness(positions, triangles):
    """(edges without exactly one opposite partner, signed volume) after merging equal positions."""
    _, merged = np.unique(positions, axis=0, return_inverse=True)
    t = merged.reshape(-1)[triangles]
    t = t[(t[:, 0] != t[:, 1]) & (t[:, 1] != t[:, 2]) & (t[:, 2] != t[:, 0])]
    edges = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    key = lambda e: e[:, 0].astype(np.int64) << 32 | e[:, 1]
    forward, forward_count = np.unique(key(edges), return_counts=True)
    backward = np.unique(key(edges[:, ::-1]))
    leaks = int((forward_count > 1).sum() + (~np.isin(forward, backward)).sum())
    a, b, c = (positions[triangles[:, i]].astype(float) for i in range(3))
    return leaks, float((a * np.cross(b, c)).sum() / 6)


def report(path):
    """Prints one line a mesh with a medium; raises if one is not closed or inside out."""
    document, binary = read(path)
    print(f"{os.path.basename(path)}: {os.path.getsize(path) / 1e6:.2f} MB, {', '.join(document.get('extensionsUsed', []))}")
    for node in document["nodes"]:
        if "mesh" not in node:
            continue
        linear = matrix(node)
        for primitive in document["meshes"][node["mesh"]]["primitives"]:
            material = document["materials"][primitive["material"]]
            medium = material.get("extensions", {}).get(NAME)
            if medium is None:
                continue
            positions = accessor(document, binary, primitive["attributes"]["POSITION"]) @ linear.T
            triangles = accessor(document, binary, primitive["indices"]).reshape(-1, 3).astype(np.int64)
            leaks, volume = closedness(positions, triangles)
            density = medium.get("densityFactor", 1)
            extinction = density * (np.array(medium["absorptionCoefficient"]) + medium["scatteringCoefficient"])
            path_mm = ", ".join(f"{1000 / t:.3g}" if t > 0 else "inf" for t in extinction)
            size = " x ".join(f"{1000 * v:.1f}" for v in np.ptp(positions, axis=0))
            print(f"  {node.get('name')}: {material['name']}, {len(triangles)} triangles, {size} mm, "
                  f"{1e6 * volume:.2f} cm3, mean free path {path_mm} mm, g {medium['scatterAnisotropy']}")
            if leaks or volume <= 0:
                raise SystemExit(f"{node.get('name')}: {leaks} open edges, volume {volume}")
