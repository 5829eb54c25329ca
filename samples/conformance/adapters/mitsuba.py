#!/usr/bin/env python3
"""Renders a case of the conformance suite with Mitsuba 3 (PyPI: mitsuba, numpy).

Boundaries are Mitsuba's smooth or rough dielectric, media homogeneous with Henyey–Greenstein scattering, the integrator is
volpathmis. Lengths are scaled so that the thinnest body is ten units thick: Mitsuba's ray epsilon is absolute. What it has
no counterpart for is said on standard error and left out: textured coefficients, and media that overlap.
"""
import glob
import os
import tempfile

import common
import gltf

common.leave_path()
if "DRJIT_LIBLLVM_PATH" not in os.environ:
    # Some older LLVMs that systems have as default cannot compile its kernels.
    found = sorted(glob.glob("/usr/lib/*/libLLVM*.so.19*") + glob.glob("/usr/lib/*/libLLVM-19.so*"))
    if found:
        os.environ["DRJIT_LIBLLVM_PATH"] = found[0]
import mitsuba as mi
import numpy as np

# No path is cut off, only played for, and late: a path survives with at most 0.95 however much it carries, so earlier roulette makes rare
# bright paths of long ones, and their light is missing from most pictures.
NO_LIMIT, ROULETTE_DEPTH = -1, 10000
# Samples of a pixel that are rendered at once, to bound memory.
CHUNK = 1 << 20


def rgb(values):
    return {"type": "rgb", "value": [float(v) for v in np.broadcast_to(values, 3)]}


def bsdf(material, outside):
    """Mitsuba's surface; `outside` is the index around it."""
    if material.medium:
        tint = {} if np.all(material.color == 1) else {"specular_transmittance": rgb(material.color)}
        if material.ior == outside:
            return {"type": "null"}
        indices = {"int_ior": float(material.ior), "ext_ior": float(outside)}
        if material.roughness == 0:
            return {"type": "dielectric", **indices, **tint}
        return {"type": "roughdielectric", "distribution": "ggx", "alpha": float(material.roughness) ** 2, **indices, **tint}
    if material.transmission > 0:
        return {"type": "thindielectric", "int_ior": float(material.ior)}
    return {"type": "diffuse", "reflectance": rgb(material.color)}


def medium(m, unit):
    """Mitsuba's medium, or `None` where there is nothing in it."""
    sigma_t = (m.sigma_a + m.sigma_s) * unit
    if not sigma_t.any():
        return None
    albedo = np.divide(m.sigma_s * unit, sigma_t, out=np.zeros(3), where=sigma_t > 0)
    phase = {"type": "hg", "g": float(m.g)} if m.g else {"type": "isotropic"}
    return {"type": "homogeneous", "sigma_t": rgb(sigma_t / sigma_t.max()), "scale": float(sigma_t.max()), "albedo": rgb(albedo), "phase": phase}


def look(matrix, unit):
    """A camera or light of glTF, which looks along −z, as one of Mitsuba's, which look along +z."""
    to_world = np.array(matrix, float)
    to_world[:3, :3] /= np.linalg.norm(to_world[:3, :3], axis=0)
    to_world[:3, 3] /= unit
    return to_world @ np.diag([-1, 1, -1, 1])


def sensor(scene, unit, width, height):
    to_world = look(scene.camera_matrix, unit)
    view = scene.camera[scene.camera["type"]]
    if scene.camera["type"] == "orthographic":
        half = view["ymag"] / unit
        to_world = to_world @ np.diag([half * width / height, half, 1, 1])
        kind = {"type": "orthographic"}
    else:
        kind = {"type": "perspective", "fov": float(np.degrees(view["yfov"])), "fov_axis": "y"}
    return {**kind, "near_clip": 1e-3, "far_clip": 1e7, "to_world": mi.ScalarTransform4f(to_world), "sampler": {"type": "independent"},
            "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}, "pixel_format": "rgb", "component_format": "float32"}}


def emitter(light, matrix, unit):
    value = np.array(light.get("color", [1, 1, 1])) * light.get("intensity", 1.0)
    to_world = look(matrix, unit)
    kind = light["type"]
    if kind == "directional":
        return {"type": "directional", "direction": [float(v) for v in to_world[:3, 2]], "irradiance": rgb(value)}
    power = rgb(value / unit**2)
    if kind == "point":
        return {"type": "point", "position": [float(v) for v in to_world[:3, 3]], "intensity": power}
    cone = light.get("spot", {})
    outer, inner = cone.get("outerConeAngle", np.pi / 4), cone.get("innerConeAngle", 0.0)
    return {"type": "spot", "to_world": mi.ScalarTransform4f(to_world), "intensity": power, "cutoff_angle": float(np.degrees(outer)),
            "beam_width": float(np.degrees(inner))}


def shape(body, unit):
    """A mesh without vertex normals."""
    mesh = mi.Mesh(body.name or "mesh", len(body.points), len(body.triangles))
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = (body.points / unit).ravel().astype(np.float32)
    parameters["faces"] = np.ascontiguousarray(body.triangles).ravel()
    parameters.update()
    return mesh


def build(scene, width, height, folder):
    gltf.left_out(scene, nested=True)
    unit = gltf.unit(scene)
    media = {id(body): medium(body.material.medium, unit) for body in scene.bodies if body.material.medium}
    d = {"type": "scene", "integrator": {"type": "volpathmis", "max_depth": NO_LIMIT, "rr_depth": ROULETTE_DEPTH},
         "sensor": sensor(scene, unit, width, height)}
    inside = gltf.around_camera(scene)
    if inside and media[id(inside)]:
        d["sensor"]["medium"] = media[id(inside)]
    if scene.environment > 0:
        d["environment"] = {"type": "constant", "radiance": rgb(scene.environment)}
    for i, (light, matrix) in enumerate(scene.lights):
        d[f"light{i}"] = emitter(light, matrix, unit)
    for i, body in enumerate(scene.bodies):
        around = gltf.containing(scene, body) if body.material.medium else None
        path = os.path.join(folder, f"{i}.ply")
        shape(body, unit).write_ply(path)
        own = {"type": "ply", "filename": path, "face_normals": True, "bsdf": bsdf(body.material, around.material.ior if around else 1.0)}
        if body.material.medium and media[id(body)]:
            own["interior"] = media[id(body)]
        if around and media[id(around)]:
            own["exterior"] = media[id(around)]
        if body.material.emission.any():
            own["emitter"] = {"type": "area", "radiance": rgb(body.material.emission)}
        d[f"shape{i}"] = own
    return mi.load_dict(d)


def main():
    args = common.arguments(__doc__, variant="llvm_ad_rgb")
    mi.set_variant(args.variant)
    with tempfile.TemporaryDirectory() as folder:
        scene = build(gltf.load(args.input), args.width, args.height, folder)
        most = max(1, CHUNK // (args.width * args.height))
        total, done = 0.0, 0
        while done < args.spp:
            n = min(most, args.spp - done)
            picture = mi.render(scene, spp=n, seed=(args.seed * 7919 + done) % 2**31)
            total = total + np.array(picture, np.float64) * n
            done += n
    mi.Bitmap((total / args.spp).astype(np.float32)).write(args.output)


if __name__ == "__main__":
    main()
