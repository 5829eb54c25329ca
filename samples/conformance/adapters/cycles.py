#!/usr/bin/env python3
"""Renders a case of the conformance suite with Blender Cycles (PyPI: bpy, numpy; Python as bpy asks for).

A boundary is the glass BSDF (GGX), a medium the volume coefficients node with Henyey–Greenstein scattering, so that Cycles
traces paths through it, unlike its principled subsurface, which approximates. Said on standard error and left out: textured
coefficients, and media that overlap or nest, where Cycles adds coefficients up. Paths end after 1024 bounces, Blender's limit.
"""
import os

import common
import gltf

common.leave_path()
import bpy
import numpy as np
from mathutils import Matrix

MOST_BOUNCES = 1024
# Blender's point and spot lights of P watts have an intensity of P/(4π).
POINT_WATTS = 4 * np.pi
# glTF has y up, Blender z.
TO_BLENDER = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], float)


def nodes(name):
    """An empty material: itself, and how to make and join nodes."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    return material, tree.nodes.new, tree.links.new, tree.nodes.new("ShaderNodeOutputMaterial")


def surface(body, outside, unit):
    """Blender's material for a body in surroundings of index `outside`."""
    own = body.material
    material, new, link, out = nodes(body.name)
    if own.medium:
        glass = new("ShaderNodeBsdfGlass" if own.ior != outside else "ShaderNodeBsdfTransparent")
        glass.inputs["Color"].default_value = (*own.color, 1)
        if own.ior != outside:
            glass.distribution = "GGX"
            glass.inputs["Roughness"].default_value = own.roughness
            glass.inputs["IOR"].default_value = own.ior / outside
        link(glass.outputs[0], out.inputs["Surface"])
        if (own.medium.sigma_a + own.medium.sigma_s).any():
            volume = new("ShaderNodeVolumeCoefficients")
            volume.phase = "HENYEY_GREENSTEIN"
            volume.inputs["Absorption Coefficients"].default_value = own.medium.sigma_a * unit
            volume.inputs["Scatter Coefficients"].default_value = own.medium.sigma_s * unit
            volume.inputs["Anisotropy"].default_value = own.medium.g
            link(volume.outputs[0], out.inputs["Volume"])
    elif own.transmission > 0:
        # A thin wall: straight on, but for the reflection of one surface.
        mix, fresnel = new("ShaderNodeMixShader"), new("ShaderNodeFresnel")
        clear, mirror = new("ShaderNodeBsdfTransparent"), new("ShaderNodeBsdfGlossy")
        fresnel.inputs["IOR"].default_value = own.ior
        mirror.inputs["Color"].default_value = (1, 1, 1, 1)
        mirror.inputs["Roughness"].default_value = 0
        link(fresnel.outputs[0], mix.inputs[0])
        link(clear.outputs[0], mix.inputs[1])
        link(mirror.outputs[0], mix.inputs[2])
        link(mix.outputs[0], out.inputs["Surface"])
    else:
        matte = new("ShaderNodeBsdfDiffuse")
        matte.inputs["Color"].default_value = (*own.color, 1)
        shader = matte
        if own.emission.any():
            shader, glow, side = new("ShaderNodeMixShader"), new("ShaderNodeEmission"), new("ShaderNodeNewGeometry")
            glow.inputs["Color"].default_value = (*own.emission, 1)
            link(side.outputs["Backfacing"], shader.inputs[0])
            link(glow.outputs[0], shader.inputs[1])
            link(matte.outputs[0], shader.inputs[2])
            material.cycles.emission_sampling = "FRONT"
        link(shader.outputs[0], out.inputs["Surface"])
    return material


def place(matrix, unit):
    """A camera's or light's matrix, in Blender's axes and the scaled unit."""
    own = TO_BLENDER @ np.array(matrix, float)
    own[:3, :3] /= np.linalg.norm(own[:3, :3], axis=0)
    own[:3, 3] /= unit
    return Matrix(own.tolist())


def add_object(name, data, matrix=None):
    thing = bpy.data.objects.new(name, data)
    if matrix is not None:
        thing.matrix_world = matrix
    bpy.context.scene.collection.objects.link(thing)
    return thing


def add_light(light, matrix, unit):
    kind = {"directional": "SUN", "point": "POINT", "spot": "SPOT"}[light["type"]]
    data = bpy.data.lights.new(light["type"], kind)
    data.color = light.get("color", [1, 1, 1])
    intensity = light.get("intensity", 1.0)
    if kind == "SUN":
        data.angle = 0
        data.energy = intensity
    else:
        data.shadow_soft_size = 0
        data.energy = intensity * POINT_WATTS / unit**2
    if kind == "SPOT":
        cone = light.get("spot", {})
        data.spot_size = 2 * cone.get("outerConeAngle", np.pi / 4)
        data.spot_blend = 0.5
    add_object(light["type"], data, place(matrix, unit))


def add_camera(scene, unit, width, height):
    view = scene.camera[scene.camera["type"]]
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "VERTICAL"
    if scene.camera["type"] == "orthographic":
        data.type = "ORTHO"
        data.ortho_scale = 2 * view["ymag"] / unit
    else:
        data.angle_y = view["yfov"]
    data.clip_start, data.clip_end = 1e-3, 1e6
    bpy.context.scene.camera = add_object("camera", data, place(scene.camera_matrix, unit))


def build(scene, width, height):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    gltf.left_out(scene, nested=False)
    unit = gltf.unit(scene)
    for body in scene.bodies:
        mesh = bpy.data.meshes.new(body.name)
        points = (body.points / unit) @ TO_BLENDER[:3, :3].T
        mesh.from_pydata(points.tolist(), [], body.triangles.tolist())
        around = gltf.containing(scene, body) if body.material.medium else None
        mesh.materials.append(surface(body, around.material.ior if around else 1.0, unit))
        add_object(body.name, mesh)
    for light, matrix in scene.lights:
        add_light(light, matrix, unit)
    add_camera(scene, unit, width, height)
    world = bpy.data.worlds.new("world")
    bpy.context.scene.world = world
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = scene.environment


def main():
    args = common.arguments(__doc__)
    build(gltf.load(args.input), args.width, args.height)
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = args.width, args.height, 100
    render.use_compositing = render.use_sequencer = False
    settings = render.image_settings
    settings.file_format, settings.color_depth, settings.color_mode, settings.exr_codec = "OPEN_EXR", "32", "RGB", "ZIP"
    scene.view_settings.view_transform = "Raw"
    render.filepath = os.path.abspath(args.output)
    cycles.device, cycles.samples, cycles.seed = "CPU", args.spp, args.seed
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.light_sampling_threshold = cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    for kind in ("max", "diffuse", "glossy", "transmission", "volume"):
        setattr(cycles, f"{kind}_bounces", MOST_BOUNCES)
    cycles.transparent_max_bounces = MOST_BOUNCES
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    main()
