"""A glTF document under construction: boxes, plates, spheres, bodies of revolution, materials, lights and one camera.

Lengths are metres. The buffer goes to a file beside the document; images are data URIs. Equal input gives equal bytes.
"""
import base64
import json
import struct
import zlib

import numpy as np

SUBSURFACE = "NEPHRITE_materials_subsurface"


def png(rows):
    """8 bit RGBA texels (a list of rows of 4-tuples) as the bytes of a PNG."""
    height, width = len(rows), len(rows[0])
    raw = b"".join(b"\0" + bytes(v for texel in row for v in texel) for row in rows)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    # Stored, not deflated: implementations of deflate differ, bytes must not.
    adler = struct.pack(">I", zlib.adler32(raw))
    stored = b"\x78\x01\x01" + struct.pack("<HH", len(raw), len(raw) ^ 0xFFFF) + raw + adler
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", stored) + chunk(b"IEND", b"")


def box(low, high):
    """An axis-aligned box that shares its eight vertices: positions and outward triangles."""
    corner = [[(high if i >> k & 1 else low)[k] for k in range(3)] for i in range(8)]
    quads = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return np.array(corner, np.float32), np.array(triangles, np.uint16)


def slab(thickness, half_width, top=0.0):
    """A box whose upper face lies at that height."""
    return box((-half_width, top - thickness, -half_width), (half_width, top, half_width))


def plate(half_width, height, up=True):
    """A square of two triangles, facing up or down."""
    w = half_width
    points = np.array([[-w, height, -w], [w, height, -w], [w, height, w], [-w, height, w]], np.float32)
    triangles = [(0, 2, 1), (0, 3, 2)] if up else [(0, 1, 2), (0, 2, 3)]
    return points, np.array(triangles, np.uint16)


def icosphere(radius, levels, equal_volume=False):
    """An icosahedron, each triangle split in four `levels` times; on request with the volume of the ball."""
    phi = 0.5 * (1 + 5**0.5)
    points = []
    for a, b in ((-1, phi), (1, phi), (-1, -phi), (1, -phi)):
        points += [(a, b, 0), (0, a, b), (b, 0, a)]
    points = [np.array(p) / np.linalg.norm(p) for p in points]
    near = lambda p, q: np.linalg.norm(p - q) < 1.2
    triangles = []
    for a in range(12):
        for b in range(a + 1, 12):
            for c in range(b + 1, 12):
                p, q, r = points[a], points[b], points[c]
                if near(p, q) and near(q, r) and near(r, p):
                    triangles.append((a, b, c) if np.dot(np.cross(q - p, r - p), p) > 0 else (a, c, b))
    for _ in range(levels):
        middles = {}

        def middle(i, j):
            key = (min(i, j), max(i, j))
            if key not in middles:
                m = points[i] + points[j]
                points.append(m / np.linalg.norm(m))
                middles[key] = len(points) - 1
            return middles[key]

        split = []
        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            split += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        triangles = split
    points = np.array(points)
    if equal_volume:
        t = points[np.array(triangles)]
        volume = np.einsum("ij,ij->i", t[:, 0], np.cross(t[:, 1], t[:, 2])).sum() / 6
        radius *= (4 / 3 * np.pi / volume) ** (1 / 3)
    return (points * radius).astype(np.float32), np.array(triangles, np.uint16)


def revolved(profile, sides):
    """A body of revolution about y with flat sides: points (radius, height) of its profile from the axis back to the axis, the
    outside to the right of the way. Points on the axis are single vertices."""
    points, rings = [], []
    for r, y in profile:
        angles = 2 * np.pi * np.arange(sides if r > 0 else 1) / sides
        rings.append(len(points) + np.arange(sides) % len(angles))
        points += [(r * np.cos(a), y, r * np.sin(a)) for a in angles]
    triangles = []
    for (low, high), (a, b) in zip(zip(rings, rings[1:]), zip(profile, profile[1:])):
        for k in range(sides):
            n = (k + 1) % sides
            if b[0] > 0:
                triangles.append((low[k], high[k], high[n]))
            if a[0] > 0:
                triangles.append((low[k], high[n], low[n]))
    return np.array(points, np.float32), np.array(triangles, np.uint16)


def joined(*meshes):
    """Several parts as one mesh."""
    first = np.cumsum([0] + [len(points) for points, _ in meshes])
    triangles = [triangles + n for (_, triangles), n in zip(meshes, first)]
    return np.concatenate([points for points, _ in meshes]), np.concatenate(triangles).astype(np.uint16)


def split_vertices(mesh):
    """Three vertices of its own for each triangle."""
    points, triangles = mesh
    return points[triangles.ravel()], np.arange(triangles.size, dtype=np.uint16).reshape(-1, 3)


def inside_out(mesh):
    """All triangles the other way round."""
    return mesh[0], mesh[1][:, ::-1].copy()


def medium(sigma_a=(0, 0, 0), sigma_s=(0, 0, 0), g=0.0, ior=1.5, roughness=0.0, color=(1, 1, 1), more=None, **own):
    """A material that is nothing but the boundary of a medium; `own` goes into the extension, `more` beside it."""
    extension = {"absorptionCoefficient": numbers(sigma_a), "scatteringCoefficient": numbers(sigma_s)}
    if g:
        extension["scatterAnisotropy"] = g
    extension["ior"] = ior
    extension.update(own)
    return surface(color, roughness, {SUBSURFACE: extension, **(more or {})})


def surface(color=(1, 1, 1), roughness=0.0, extensions=None, **more):
    """A dielectric."""
    pbr = {"baseColorFactor": [*numbers(color), 1], "metallicFactor": 0, "roughnessFactor": roughness}
    material = {"pbrMetallicRoughness": pbr, **more}
    if extensions:
        material["extensions"] = extensions
    return material


def black(emission=None):
    """A material that reflects nothing, and shines with that radiance if there is one."""
    material = surface((0, 0, 0), 1.0, {"KHR_materials_specular": {"specularFactor": 0}})
    if emission is not None:
        strength = max(emission)
        material["emissiveFactor"] = numbers(e / strength for e in emission)
        if strength != 1:
            material["extensions"]["KHR_materials_emissive_strength"] = {"emissiveStrength": number(strength)}
    return material


def number(value):
    """A number as it is written: nine digits, and no point where there are no decimals."""
    value = float(f"{float(value):.9g}")
    return int(value) if value == int(value) and abs(value) < 1e15 else value


def numbers(values):
    return [number(v) for v in values]


def look_along(direction, center, distance):
    """A node matrix (column by column) for a camera or a light that looks along `direction` at `center`."""
    z = -np.asarray(direction, float) / np.linalg.norm(direction)
    helper = np.array([1.0, 0, 0]) if abs(z[1]) > 0.9 else np.array([0, 1.0, 0])
    x = np.cross(helper, z)
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    origin = np.asarray(center, float) + z * distance
    rows = [[*x, 0], [*y, 0], [*z, 0], [*origin, 1]]
    return [number(v) for row in rows for v in row]


class Document:
    """Meshes, nodes and the rest; `write` puts them into a folder."""

    def __init__(self, generator):
        self.json = {"asset": {"version": "2.0", "generator": generator}, "scene": 0, "scenes": [{"nodes": []}],
                     "nodes": [], "meshes": [], "materials": [], "accessors": [], "bufferViews": []}
        self.data = bytearray()

    def refracts(self):
        """Whether light meets the boundary of a medium of an index other than 1."""
        def index(extensions):
            if SUBSURFACE in extensions:
                return extensions[SUBSURFACE].get("ior", 1.5)
            inside = extensions.get("KHR_materials_volume", {}).get("thicknessFactor", 0) > 0
            return extensions.get("KHR_materials_ior", {}).get("ior", 1.5) if inside else 1
        return any(index(material.get("extensions", {})) != 1 for material in self.json["materials"])

    def view(self, array, target):
        self.data += b"\0" * (-len(self.data) % 4)
        self.json["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(self.data), "byteLength": array.nbytes, "target": target})
        self.data += array.tobytes()
        return len(self.json["bufferViews"]) - 1

    def accessor(self, array, kind, component, target, **more):
        view = self.view(array, target)
        count = len(array) if array.ndim > 1 else array.size
        self.json["accessors"].append(
            {"bufferView": view, "componentType": component, "count": count, "type": kind, **more})
        return len(self.json["accessors"]) - 1

    def mesh(self, mesh, material, uvs=None, normals=None):
        """A mesh of one material, and its index."""
        points, triangles = mesh
        low, high = ([float(v) for v in f(points, axis=0)] for f in (np.min, np.max))
        attributes = {"POSITION": self.accessor(points, "VEC3", 5126, 34962, min=low, max=high)}
        if normals is not None:
            attributes["NORMAL"] = self.accessor(np.asarray(normals, np.float32), "VEC3", 5126, 34962)
        if uvs is not None:
            attributes["TEXCOORD_0"] = self.accessor(np.asarray(uvs, np.float32), "VEC2", 5126, 34962)
        indices = self.accessor(triangles.reshape(-1), "SCALAR", 5123, 34963)
        self.json["materials"].append(material)
        primitive = {"attributes": attributes, "indices": indices, "material": len(self.json["materials"]) - 1}
        self.json["meshes"].append({"primitives": [primitive]})
        return len(self.json["meshes"]) - 1

    def node(self, **node):
        self.json["nodes"].append(node)
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]) - 1)

    def add(self, mesh, material, name, uvs=None, normals=None, **place):
        """A mesh in a node of its own."""
        self.node(name=name, mesh=self.mesh(mesh, material, uvs, normals), **place)

    def camera(self, direction, half_height, center=(0, 0, 0), distance=1.0):
        """A square orthographic camera."""
        h = number(half_height)
        view = {"xmag": h, "ymag": h, "znear": 0, "zfar": number(2 * distance)}
        self.json["cameras"] = [{"type": "orthographic", "orthographic": view}]
        self.node(name="camera", camera=0, matrix=look_along(direction, center, distance))

    def perspective(self, direction, yfov, origin=(0, 0, 0)):
        """A square perspective camera."""
        view = {"aspectRatio": 1, "yfov": number(yfov), "znear": 1e-6}
        self.json["cameras"] = [{"type": "perspective", "perspective": view}]
        self.node(name="camera", camera=0, matrix=look_along(direction, origin, 0.0))

    def environment(self, radiance):
        """The same radiance from everywhere."""
        self.json.setdefault("images", []).append({"uri": uri(png([[(255, 255, 255, 255)]]))})
        image = len(self.json["images"]) - 1
        light = {"intensity": number(radiance), "specularImageSize": 1, "specularImages": [[image] * 6],
                 # Irradiance π L everywhere, over Y_00 = 1/(2 √π).
                 "irradianceCoefficients": [[number(2 * np.pi**1.5 * radiance)] * 3] + [[0, 0, 0]] * 8}
        self.json.setdefault("extensions", {})["EXT_lights_image_based"] = {"lights": [light]}
        self.json["scenes"][0]["extensions"] = {"EXT_lights_image_based": {"light": 0}}

    def light(self, light, direction=(0, -1, 0), origin=(0, 0, 0)):
        """A punctual light."""
        lights = self.json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})["lights"]
        lights.append(light)
        self.node(name=light["type"], matrix=look_along(direction, origin, 0.0),
                  extensions={"KHR_lights_punctual": {"light": len(lights) - 1}})

    def texture(self, rows):
        """A texture of 8 bit texels, looked up at the nearest one; its index."""
        images = self.json.setdefault("images", [])
        images.append({"uri": uri(png(rows))})
        self.json["samplers"] = [{"magFilter": 9728, "minFilter": 9728, "wrapS": 33071, "wrapT": 33071}]
        textures = self.json.setdefault("textures", [])
        textures.append({"source": len(images) - 1, "sampler": 0})
        return len(textures) - 1

    def write(self, folder, name):
        """Writes NAME.gltf and NAME.bin."""
        document = self.json
        used = set()

        def collect(value):
            if isinstance(value, dict):
                used.update(value.get("extensions", {}))
                value = list(value.values())
            if isinstance(value, list):
                for item in value:
                    collect(item)

        collect(document)
        if used:
            document = {**document, "extensionsUsed": sorted(used)}
        document["buffers"] = [{"byteLength": len(self.data), "uri": f"{name}.bin"}]
        (folder / f"{name}.gltf").write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n")
        (folder / f"{name}.bin").write_bytes(bytes(self.data))


def uri(image):
    return "data:image/png;base64," + base64.b64encode(image).decode()
