"""Reads what the conformance suite uses of glTF into plain arrays, for the adapters of other renderers.

Everything is in world space and metres. Media are resolved: NEPHRITE_materials_subsurface, else KHR_materials_scatter, else
KHR_materials_volume_scatter, else KHR_materials_volume. Meshes that are inside out or mirrored are turned right.
"""
import base64
import dataclasses
import json
import pathlib
import sys

import numpy as np

TYPES = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
SIZES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


@dataclasses.dataclass
class Medium:
    """Coefficients in 1/m; `textured` says that they vary, which is not resolved here."""

    sigma_a: np.ndarray
    sigma_s: np.ndarray
    g: float = 0.0
    priority: int = 0
    textured: bool = False


@dataclasses.dataclass
class Material:
    """A dielectric; with a medium, or with transmission alone a thin wall, else black or opaque. `alpha` says that it does not
    cover everywhere, which is not resolved here."""

    color: np.ndarray
    roughness: float
    ior: float
    transmission: float
    emission: np.ndarray
    medium: Medium = None
    alpha: bool = False


@dataclasses.dataclass
class Body:
    """A mesh in its place."""

    name: str
    points: np.ndarray
    triangles: np.ndarray
    material: Material

    @property
    def bounds(self):
        return self.points.min(axis=0), self.points.max(axis=0)


@dataclasses.dataclass
class Scene:
    bodies: list = dataclasses.field(default_factory=list)
    camera: dict = None
    camera_matrix: np.ndarray = None
    lights: list = dataclasses.field(default_factory=list)
    environment: float = 0.0


def load(path):
    """The scene of a .gltf file."""
    path = pathlib.Path(path)
    document = json.loads(path.read_text())
    buffers = [contents(path, buffer["uri"]) for buffer in document.get("buffers", [])]
    materials = [material(m) for m in document.get("materials", [])]
    scene = Scene()

    def accessor(index):
        a = document["accessors"][index]
        view = document["bufferViews"][a["bufferView"]]
        kind, size = np.dtype(TYPES[a["componentType"]]), SIZES[a["type"]]
        start = view.get("byteOffset", 0) + a.get("byteOffset", 0)
        values = np.frombuffer(buffers[view["buffer"]], kind, a["count"] * size, start)
        return values.reshape(a["count"], size)

    def visit(index, parent):
        node = document["nodes"][index]
        matrix = parent @ local(node)
        if "mesh" in node:
            for primitive in document["meshes"][node["mesh"]]["primitives"]:
                points = accessor(primitive["attributes"]["POSITION"]) @ matrix[:3, :3].T + matrix[:3, 3]
                triangles = accessor(primitive["indices"]).reshape(-1, 3).astype(np.uint32)
                own = materials[primitive["material"]]
                scene.bodies.append(Body(node.get("name", ""), points, outward(points, triangles, own), own))
        if "camera" in node:
            scene.camera, scene.camera_matrix = document["cameras"][node["camera"]], matrix
        light = node.get("extensions", {}).get("KHR_lights_punctual")
        if light:
            scene.lights.append((document["extensions"]["KHR_lights_punctual"]["lights"][light["light"]], matrix))
        for child in node.get("children", []):
            visit(child, matrix)

    root = document["scenes"][document.get("scene", 0)]
    for index in root["nodes"]:
        visit(index, np.eye(4))
    around = root.get("extensions", {}).get("EXT_lights_image_based")
    if around:
        # The suite's environments are uniform: white images times an intensity.
        scene.environment = document["extensions"]["EXT_lights_image_based"]["lights"][around["light"]].get("intensity", 1.0)
    return scene


def contents(path, uri):
    if uri.startswith("data:"):
        return base64.b64decode(uri.split(",", 1)[1])
    return (path.parent / uri).read_bytes()


def local(node):
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    matrix = np.eye(4)
    matrix[:3, :3] = turn * np.array(node.get("scale", [1, 1, 1]))
    matrix[:3, 3] = node.get("translation", [0, 0, 0])
    return matrix


def outward(points, triangles, material):
    """Triangles of a body that holds a medium, turned so that they face outwards."""
    corners = points[triangles].astype(float)
    volume = np.einsum("ij,ij->i", corners[:, 0] - points[0], np.cross(corners[:, 1] - points[0], corners[:, 2] - points[0])).sum()
    return triangles[:, ::-1] if material.medium and volume < 0 else triangles


def material(m):
    own = m.get("extensions", {})
    pbr = m.get("pbrMetallicRoughness", {})
    get = lambda name, key, default: own.get(name, {}).get(key, default)
    strength = get("KHR_materials_emissive_strength", "emissiveStrength", 1.0)
    subsurface = own.get("NEPHRITE_materials_subsurface")
    ior = get("KHR_materials_ior", "ior", 1.5)
    transmission = get("KHR_materials_transmission", "transmissionFactor", 0.0)
    medium = None
    if subsurface is not None:
        density = subsurface.get("densityFactor", 1.0)
        coefficient = lambda key: density * np.array(subsurface.get(key, [0, 0, 0]), float)
        medium = Medium(coefficient("absorptionCoefficient"), coefficient("scatteringCoefficient"), subsurface.get("scatterAnisotropy", 0.0),
                        subsurface.get("priority", 0), "absorptionTexture" in subsurface or "scatteringTexture" in subsurface)
        ior = subsurface.get("ior", ior)
        if "KHR_materials_transmission" not in own:
            transmission = 1.0
    elif get("KHR_materials_volume", "thicknessFactor", 0) > 0 and transmission > 0:
        color = np.array(get("KHR_materials_volume", "attenuationColor", [1, 1, 1]), float)
        sigma_t = -np.log(np.maximum(color, 1e-6)) / get("KHR_materials_volume", "attenuationDistance", np.inf)
        albedo, g = np.zeros(3), 0.0
        for name, strong, mapped in (("KHR_materials_scatter", "scatterStrengthFactor", True), ("KHR_materials_volume_scatter", None, False)):
            if name in own:
                g = own[name].get("scatterAnisotropy", 0.0)
                rho = np.array(own[name].get("multiscatterColorFactor", [1, 1, 1]), float) * (own[name].get(strong, 0.0) if strong else 1.0)
                s = 4.09712 + 4.20863 * rho - np.sqrt(9.59217 + 41.6808 * rho + 17.7126 * rho**2)
                albedo = (1 - s * s) / (1 - (g if mapped else 0.0) * s * s)
                break
        medium = Medium(sigma_t * (1 - albedo), sigma_t * albedo, g)
    return Material(np.array(pbr.get("baseColorFactor", [1, 1, 1, 1])[:3], float), pbr.get("roughnessFactor", 1.0), ior, transmission,
                    strength * np.array(m.get("emissiveFactor", [0, 0, 0]), float), medium, m.get("alphaMode", "OPAQUE") != "OPAQUE")


def containing(scene, body):
    """The smallest other body with a medium whose bounds hold those of this one, or `None`."""
    low, high = body.bounds
    around = [other for other in scene.bodies if other is not body and other.material.medium
              and np.all(other.bounds[0] <= low) and np.all(other.bounds[1] >= high)]
    return min(around, key=lambda other: np.prod(other.bounds[1] - other.bounds[0]), default=None)


def overlapping(scene):
    """Names of bodies with media whose bounds overlap those of another one without either holding the other."""
    bodies = [b for b in scene.bodies if b.material.medium]
    meet = lambda a, b: np.all(a.bounds[0] < b.bounds[1]) and np.all(b.bounds[0] < a.bounds[1])
    holds = lambda a, b: np.all(a.bounds[0] <= b.bounds[0]) and np.all(a.bounds[1] >= b.bounds[1])
    return [a.name for a in bodies if any(a is not b and meet(a, b) and not holds(a, b) and not holds(b, a) for b in bodies)]


def around_camera(scene):
    """The body with a medium that a perspective camera is in, by its bounds, or `None`."""
    if scene.camera["type"] != "perspective":
        return None
    eye = scene.camera_matrix[:3, 3]
    inside = [b for b in scene.bodies if b.material.medium and np.all(b.bounds[0] < eye) and np.all(b.bounds[1] > eye)]
    return min(inside, key=lambda b: np.prod(b.bounds[1] - b.bounds[0]), default=None)


def left_out(scene, nested):
    """Says on standard error what a renderer without counterparts shows differently; `nested` says whether it can nest media."""
    for body in scene.bodies:
        if body.material.medium and body.material.medium.textured:
            print(f"{body.name}: textured coefficients are not translated", file=sys.stderr)
        if body.material.alpha:
            print(f"{body.name}: alpha is not translated; it covers all", file=sys.stderr)
        if not nested and body.material.medium and containing(scene, body):
            print(f"{body.name}: lies within another medium; both count", file=sys.stderr)
    for name in overlapping(scene):
        print(f"{name}: overlaps another medium; there are no priorities", file=sys.stderr)


def unit(scene):
    """A length of which the thinnest body with a medium has ten: renderers with absolute epsilons are at ease in it."""
    extents = [np.min(b.bounds[1] - b.bounds[0]) for b in scene.bodies if b.material.medium]
    return min(extents, default=10.0) / 10
