"""The photographer's studio: materials, sweep, panels, lamps and camera."""
import math

import bpy
from mathutils import Vector

from . import gltf_subsurface


def reset():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 480, 360
    scene.unit_settings.system = "METRIC"


def material(name, base=(1, 1, 1), roughness=0.5, metallic=0.0, emission=None, ior=1.5, specular=None):
    """A Principled material with glTF's meaning; linear colours; `emission` is radiance (RGB)."""
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    m.use_backface_culling = True
    inputs = principled(m).inputs
    inputs["Base Color"].default_value = (*base, 1)
    inputs["Roughness"].default_value = roughness
    inputs["Metallic"].default_value = metallic
    inputs["IOR"].default_value = ior
    if specular is not None:
        inputs["Specular IOR Level"].default_value = specular / 2
    if emission is not None:
        strength = max(emission)
        inputs["Emission Color"].default_value = (*(c / strength for c in emission), 1)
        inputs["Emission Strength"].default_value = strength
    return m


def principled(m):
    return next(n for n in m.node_tree.nodes if n.type == "BSDF_PRINCIPLED")


def subsurface(name, medium, roughness, thickness=0.02):
    m = material(name, roughness=roughness, ior=medium.ior)
    gltf_subsurface.attach(m, medium, thickness)
    return m


def image(name, pixels, color=False):
    """A packed 8-bit image of an array (rows from the top, columns, 3); linear data unless `color` (sRGB encoded)."""
    import numpy as np

    height, width, _ = pixels.shape
    item = bpy.data.images.new(name, width, height, alpha=False, is_data=not color)
    item.colorspace_settings.name = "sRGB" if color else "Non-Color"
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = pixels[::-1]
    item.pixels.foreach_set(rgba.ravel())
    item.file_format = "PNG"
    item.pack()
    return item


def emitter(name, radiance):
    return material(name, base=(0, 0, 0), roughness=1.0, emission=radiance, specular=0.0)


def aim(item, target):
    """Turns an object so that its −Z points at a target, Y up."""
    item.rotation_euler = (Vector(target) - item.location).to_track_quat("-Z", "Y").to_euler()


def panel(name, position, target, size, radiance):
    """A rectangle that shines from its front, towards a target. Radiance is RGB."""
    w, h = (size, size) if isinstance(size, (int, float)) else size
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(-w / 2, -h / 2, 0), (-w / 2, h / 2, 0), (w / 2, h / 2, 0), (w / 2, -h / 2, 0)], [], [(0, 1, 2, 3)])
    mesh.materials.append(emitter(name, radiance))
    item = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(item)
    item.location = position
    aim(item, target)
    return item


def sweep(color=(0.5, 0.5, 0.5), width=3.0, front=-1.5, back=0.5, height=1.5, radius=0.25, roughness=0.6, z=0.0, specular=0.3):
    """A floor that bends up into a wall, seamless. The camera looks along +Y."""
    profile = [(front, z)]
    for i in range(13):
        a = math.pi / 2 * i / 12
        profile.append((back - radius + radius * math.sin(a), z + radius - radius * math.cos(a)))
    profile.append((back, z + height))
    vertices = [(x, y, h) for y, h in profile for x in (-width / 2, width / 2)]
    faces = [(2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2) for i in range(len(profile) - 1)]
    mesh = bpy.data.meshes.new("sweep")
    mesh.from_pydata(vertices, [], faces)
    for polygon in mesh.polygons:
        polygon.use_smooth = True
    mesh.materials.append(material("sweep", color, roughness, specular=specular))
    item = bpy.data.objects.new("sweep", mesh)
    bpy.context.scene.collection.objects.link(item)
    return item


def lamp(name, kind, position, color, intensity, target=None, angle=60.0, blend=0.3):
    """A light without size: `intensity` is candela for POINT and SPOT and lux for SUN."""
    data = bpy.data.lights.new(name, kind)
    data.color = color
    # The exporter's standard lighting model divides watts by 4 pi and multiplies by 683 lm/W.
    data.energy = intensity if kind == "SUN" else intensity * 4 * math.pi / 683
    if kind == "SPOT":
        data.spot_size, data.spot_blend = math.radians(angle), blend
    item = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(item)
    item.location = position
    if target is not None:
        aim(item, target)
    return item


def camera(position, target, millimetres=70.0):
    """A lens of so many millimetres before a film 36 mm wide."""
    data = bpy.data.cameras.new("camera")
    data.lens, data.clip_start, data.clip_end = millimetres, 0.01, 100.0
    item = bpy.data.objects.new("camera", data)
    bpy.context.scene.collection.objects.link(item)
    item.location = position
    aim(item, target)
    bpy.context.scene.camera = item
    return item
