"""Writes the example assets of the specification: small .gltf files without companions, Python's own library only.

    python3 extensions/NEPHRITE_materials_subsurface/examples/make.py

Each holds a closed sphere (or several) in front of a grey wall, a camera and two emissive panels, one in front and one
behind, so that what the medium does to light is seen both reflected and shining through. The README quotes the first
materials of each file; a test holds the two together.
"""
import base64
import json
import math
import os
import struct
import zlib

EXTENSION = "NEPHRITE_materials_subsurface"
AROUND, ALONG = 48, 24


def data_uri(data, mime="application/octet-stream"):
    return f"data:{mime};base64," + base64.b64encode(data).decode()


def uv_sphere():
    """Unit sphere; the seam's vertices are doubled with equal positions. Normals are the positions."""
    positions, uvs, triangles = [], [], []
    for j in range(ALONG + 1):
        polar = math.pi * j / ALONG
        ring = 0.0 if j in (0, ALONG) else math.sin(polar)
        for i in range(AROUND + 1):
            azimuth = 2 * math.pi * (i % AROUND) / AROUND
            positions.append((ring * math.cos(azimuth), math.cos(polar), -ring * math.sin(azimuth)))
            uvs.append((i / AROUND, j / ALONG))
    for j in range(ALONG):
        for i in range(AROUND):
            a, b = j * (AROUND + 1) + i, (j + 1) * (AROUND + 1) + i
            if j > 0:
                triangles.append((a, b, a + 1))
            if j < ALONG - 1:
                triangles.append((a + 1, b, b + 1))
    return positions, uvs, triangles


def png(width, height, pixel):
    """An 8-bit RGB PNG of pixel(x, y) -> (r, g, b) in [0, 1], linear data."""
    rows = b""
    for y in range(height):
        rows += b"\0" + bytes(round(255 * c) for x in range(width) for c in pixel(x, y))
    chunk = lambda kind, body: struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")


class Asset:
    """One example: bodies are (name, centre, radius or three half axes, material index), in centimetres."""

    def __init__(self, title, materials, bodies, images=()):
        self.title, self.materials, self.bodies, self.images = title, materials, bodies, images

    def document(self):
        chunks, views, accessors = [], [], []

        def accessor(values, kind, component, target, bounds=False):
            code = {"f": 5126, "H": 5123}[component]
            flat = [v for row in values for v in row]
            data = struct.pack(f"<{len(flat)}{component}", *flat)
            offset = sum(len(c) for c in chunks)
            chunks.append(data + b"\0" * (-len(data) % 4))
            views.append({"buffer": 0, "byteOffset": offset, "byteLength": len(data), "target": target})
            per = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[kind]
            entry = {"bufferView": len(views) - 1, "componentType": code, "count": len(flat) // per, "type": kind}
            if bounds:
                single = [[struct.unpack("<f", struct.pack("<f", v))[0] for v in column] for column in zip(*values)]
                entry |= {"min": [min(c) for c in single], "max": [max(c) for c in single]}
            accessors.append(entry)
            return len(accessors) - 1

        positions, uvs, triangles = uv_sphere()
        position = accessor(positions, "VEC3", "f", 34962, bounds=True)
        uv = accessor(uvs, "VEC2", "f", 34962) if self.images else None
        index = accessor([(i,) for t in triangles for i in t], "SCALAR", "H", 34963)
        square = [(-0.5, -0.5, 0.0), (0.5, -0.5, 0.0), (0.5, 0.5, 0.0), (-0.5, 0.5, 0.0)]
        quad_position = accessor(square, "VEC3", "f", 34962, bounds=True)
        quad_index = accessor([(i,) for i in (0, 1, 2, 0, 2, 3)], "SCALAR", "H", 34963)

        wall, panel = len(self.materials), len(self.materials) + 1
        materials = self.materials + [
            {"name": "wall", "pbrMetallicRoughness": {"baseColorFactor": [0.35, 0.37, 0.4, 1], "metallicFactor": 0}},
            {
                "name": "panel",
                "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0},
                "emissiveFactor": [1, 1, 1],
                "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 6}},
            },
        ]
        meshes, nodes = [], []
        for name, centre, radius, material in self.bodies:
            attributes = {"POSITION": position, "NORMAL": position} | ({"TEXCOORD_0": uv} if uv is not None else {})
            meshes.append({"name": name, "primitives": [{"attributes": attributes, "indices": index, "material": material}]})
            axes = radius if isinstance(radius, tuple) else (radius,) * 3
            nodes.append({"name": name, "mesh": len(meshes) - 1, "translation": [c / 100 for c in centre], "scale": [r / 100 for r in axes]})

        def square_node(name, mesh_material, translation, toward, size):
            """A quad whose +Z face looks along `toward`."""
            meshes.append({"name": name, "primitives": [{"attributes": {"POSITION": quad_position}, "indices": quad_index, "material": mesh_material}]})
            yaw = math.atan2(toward[0], toward[2])
            pitch = -math.atan2(toward[1], math.hypot(toward[0], toward[2]))
            sy, cy, sp, cp = math.sin(yaw / 2), math.cos(yaw / 2), math.sin(pitch / 2), math.cos(pitch / 2)
            nodes.append({"name": name, "mesh": len(meshes) - 1, "translation": [c / 100 for c in translation],
                          "rotation": [round(v, 7) for v in (cy * sp, sy * cp, -sy * sp, cy * cp)], "scale": [size / 100, size / 100, 1]})

        square_node("wall", wall, (0, 0, -14), (0, 0, 1), 60)
        square_node("key panel", panel, (-9, 10, 9), (9, -10, -9), 8)
        square_node("back panel", panel, (11, 5, -9), (-11, -5, 9), 7)
        nodes.append({"name": "camera", "camera": 0, "translation": [0, 0, 0.16]})

        used = sorted({EXTENSION} | {e for m in materials for e in m.get("extensions", {})}
                      | {e for m in self.materials for t in m.get("extensions", {}).get(EXTENSION, {}).values()
                         if isinstance(t, dict) for e in t.get("extensions", {})})
        document = {
            "asset": {"version": "2.0", "generator": f"examples of {EXTENSION}", "extras": {"title": self.title}},
            "extensionsUsed": used,
            "scene": 0,
            "scenes": [{"nodes": list(range(len(nodes)))}],
            "nodes": nodes,
            "cameras": [{"type": "perspective", "perspective": {"yfov": 0.4, "aspectRatio": 1.3333333, "znear": 0.01}}],
            "materials": materials,
            "meshes": meshes,
            "accessors": accessors,
            "bufferViews": views,
        }
        blob = b"".join(chunks)
        document["buffers"] = [{"byteLength": len(blob), "uri": data_uri(blob)}]
        if self.images:
            document["samplers"] = [{"magFilter": 9729, "minFilter": 9729, "wrapS": 10497, "wrapT": 33071}]
            document["textures"] = [{"sampler": 0, "source": i} for i in range(len(self.images))]
            document["images"] = [{"name": n, "mimeType": "image/png", "uri": data_uri(p, "image/png")} for n, p in self.images]
        return document


def subsurface(name, roughness=0.1, base=None, extensions=None, **properties):
    pbr = ({"baseColorFactor": base} if base else {}) | {"metallicFactor": 0, "roughnessFactor": roughness}
    return {"name": name, "pbrMetallicRoughness": pbr, "extensions": {EXTENSION: properties} | (extensions or {})}


def khronos_fallback(absorption, scattering, anisotropy, ior, scale):
    """The section "Fallback for other readers" of the README, rounded to six digits, for a mesh in a node of this scale."""
    extinction = [a + s for a, s in zip(absorption, scattering)]
    distance = 1 / max(extinction)
    color, albedo = [], []
    for a, s, t in zip(absorption, scattering, extinction):
        similar = math.sqrt((1 - s / t) / (1 - anisotropy * s / t))
        color.append(round(math.exp(-t * distance), 6))
        albedo.append(round((1 - similar) * (1 - 0.139 * similar) / (1 + 1.17 * similar), 6))
    return {
        "KHR_materials_ior": {"ior": ior},
        "KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_volume": {"thicknessFactor": float(f"{distance / 4 / scale:.6g}"), "attenuationDistance": float(f"{distance:.6g}"), "attenuationColor": color},
        "KHR_materials_scatter": {"scatterStrengthFactor": 1, "multiscatterColorFactor": albedo, "scatterAnisotropy": anisotropy},
    }


def bands(x, y):
    """White with three dark bands of latitude: where it is dark the coefficient is small."""
    wave = 0.5 + 0.5 * math.cos(2 * math.pi * 3 * y / 32)
    return (0.15 + 0.85 * wave,) * 3


def spots(x, y):
    """Red light is absorbed in spots, blue light between them."""
    wave = 0.5 + 0.5 * math.cos(2 * math.pi * 6 * x / 64) * math.cos(2 * math.pi * 3 * y / 32)
    return (wave, 0.3, 1 - wave)


WHOLE = ("ball", (0, 0, 0), 2.0)
EXAMPLES = {
    "marble": Asset("Marble, measured coefficients", [
        subsurface("marble", absorptionCoefficient=[2.1, 4.1, 7.1], scatteringCoefficient=[2190, 2620, 3000], ior=1.5)], [(*WHOLE, 0)]),
    "fallback": Asset("Skim milk, with what other readers understand", [
        subsurface("skim milk", 0.05, extensions=khronos_fallback([1.4, 2.5, 14.2], [700, 1220, 1900], 0.0, 1.3, 0.02),
                   absorptionCoefficient=[1.4, 2.5, 14.2], scatteringCoefficient=[700, 1220, 1900], ior=1.3)], [(*WHOLE, 0)]),
    "textured": Asset("Coefficients that vary", [
        subsurface("banded candy", absorptionCoefficient=[150, 150, 150],
                   absorptionTexture={"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 1]}}},
                   scatteringCoefficient=[900, 900, 900], scatteringTexture={"index": 1}, ior=1.45)], [(*WHOLE, 0)],
        images=[("spots", png(64, 32, spots)), ("bands", png(64, 32, bands))]),
    "nested": Asset("A jade bead in amber", [
        subsurface("amber", 0.02, absorptionCoefficient=[4, 22, 95], ior=1.54),
        subsurface("jade", 0.2, absorptionCoefficient=[60, 18, 45], scatteringCoefficient=[900, 950, 900], ior=1.61, priority=1)],
        [(*WHOLE, 0), ("bead", (0.3, -0.2, 0), (0.9, 0.7, 0.7), 1)]),
    "clear": Asset("Clear glass: no coefficients", [
        subsurface("glass", 0, ior=1.52)], [(*WHOLE, 0)]),
    "forward": Asset("Strongly forward scattering, diluted", [
        subsurface("milky water", 0, absorptionCoefficient=[2.875, 5.75, 11.5], scatteringCoefficient=[13115.7, 15444.5, 17957.2],
                   scatterAnisotropy=0.9, ior=1.33, densityFactor=0.03)], [(*WHOLE, 0)]),
    "half-transmission": Asset("Half of the light goes to the opaque base", [
        subsurface("glazed clay", 0.3, base=[0.6, 0.25, 0.15, 1], extensions={"KHR_materials_transmission": {"transmissionFactor": 0.5}},
                   absorptionCoefficient=[20, 30, 60], scatteringCoefficient=[800, 700, 600])], [(*WHOLE, 0)]),
    "scaled": Asset("One material on bodies of two sizes", [
        subsurface("soap", absorptionCoefficient=[10, 40, 60], scatteringCoefficient=[400, 420, 450], scatterAnisotropy=0.3, ior=1.47)],
        [("small", (-2.4, 0, 0), 0.6, 0), ("large", (0.9, 0, 0), 2.0, 0)]),
}

if __name__ == "__main__":
    folder = os.path.dirname(os.path.abspath(__file__))
    for name, asset in EXAMPLES.items():
        with open(os.path.join(folder, name + ".gltf"), "w", encoding="utf-8") as file:
            json.dump(asset.document(), file, indent=1)
            file.write("\n")
