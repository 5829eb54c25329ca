"""The scene of docs/from-blender.md: a smooth body of jade, tea in a glass, a painted head, lit by a sun, a spot, an area
light and a grey world, as one would build them for Cycles.

    pip install bpy==4.5.15      # Python 3.11
    python3 scene.py             # writes exported.glb and prints the commands
    python3 scene.py --cycles cycles.png

Lengths are metres.
"""
import math
import os
import sys

import bpy
import numpy as np
from mathutils import Vector

import to_nephrite

HERE = os.path.dirname(os.path.abspath(__file__))
MM = 0.001


def material(name, **inputs):
    """A Principled material; inputs by their names, with _ for spaces."""
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    node = next(n for n in m.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    for key, value in inputs.items():
        color = np.size(value) == 3 and key != "Subsurface_Radius"
        node.inputs[key.replace("_", " ")].default_value = (*value, 1) if color else value
    return m, node


def put(item, m, smooth=True):
    item.data.materials.append(m)
    for polygon in item.data.polygons:
        polygon.use_smooth = smooth
    return item


def lathe(name, profile, m, n=96):
    """A body of revolution, closed: the profile starts and ends on the axis."""
    inner = profile[1:-1]
    around = [(math.cos(2 * math.pi * i / n), math.sin(2 * math.pi * i / n)) for i in range(n)]
    vertices = [(0, 0, profile[0][1]), *((r * x, r * y, z) for r, z in inner for x, y in around), (0, 0, profile[-1][1])]
    at = lambda j, i: 1 + j * n + i % n
    last = len(inner) - 1
    faces = [(0, at(0, i + 1), at(0, i)) for i in range(n)] + [(len(vertices) - 1, at(last, i), at(last, i + 1)) for i in range(n)]
    faces += [(at(j, i), at(j, i + 1), at(j + 1, i + 1), at(j + 1, i)) for j in range(last) for i in range(n)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    item = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(item)
    return put(item, m)


def rounded(points, radius, n=6):
    """Corners of a profile rounded off by arcs (quadratic curves), so that smooth shading has something to be smooth on."""
    out = [points[0]]
    for a, b, c in zip(points, points[1:], points[2:]):
        a, b, c = Vector(a), Vector(b), Vector(c)
        r = min(radius, (a - b).length / 2, (c - b).length / 2)
        start, end = b + (a - b).normalized() * r, b + (c - b).normalized() * r
        out += [tuple(start * (1 - t) ** 2 + 2 * b * t * (1 - t) + end * t * t) for t in (i / n for i in range(n + 1))]
    return out + [points[-1]]


def face(size=256):
    """A painted face over the longitudes and latitudes of a sphere: skin, cheeks, lips, brows and eyes. sRGB."""
    v, u = np.mgrid[0:size, 0:2 * size]
    x, y = (u + 0.5) / (2 * size) * 2 - 1, (v + 0.5) / size        # x = 0 is the front, y = 0 the chin's side
    picture = np.empty((size, 2 * size, 3))
    picture[:] = (0.87, 0.68, 0.58)

    def spot(cx, cy, rx, ry, color, soft):
        weight = np.clip((1 - np.sqrt(((x - cx) / rx) ** 2 + ((y - cy) / ry) ** 2)) / soft, 0, 1)[..., None]
        picture[:] = picture * (1 - weight) + np.array(color) * weight

    for side in (-1, 1):
        spot(side * 0.15, 0.44, 0.10, 0.10, (0.86, 0.47, 0.42), 1.0)
        spot(side * 0.105, 0.585, 0.045, 0.035, (0.93, 0.91, 0.88), 0.2)
        spot(side * 0.100, 0.585, 0.020, 0.034, (0.18, 0.12, 0.10), 0.2)
        spot(side * 0.110, 0.665, 0.065, 0.014, (0.33, 0.20, 0.14), 0.5)
    spot(0, 0.37, 0.07, 0.026, (0.72, 0.25, 0.24), 0.5)
    picture[y > 0.78 - 0.03 * np.cos(6 * np.pi * x)] = (0.33, 0.20, 0.14)
    image = bpy.data.images.new("face", 2 * size, size, alpha=False)
    pixels = np.ones((size, 2 * size, 4), np.float32)
    pixels[..., :3] = picture
    image.pixels.foreach_set(pixels.ravel())
    image.file_format = "PNG"
    image.pack()
    return image


def aim(item, target):
    item.rotation_euler = (Vector(target) - item.location).to_track_quat("-Z", "Y").to_euler()


def light(name, kind, position, target, energy, **more):
    data = bpy.data.lights.new(name, kind)
    data.energy = energy
    for key, value in more.items():
        setattr(data, key, value)
    item = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(item)
    item.location = position
    aim(item, target)
    return item


def bodies():
    jade, node = material("jade", Base_Color=(0.25, 0.55, 0.35), Roughness=0.25, IOR=1.5,
                          Subsurface_Weight=1, Subsurface_Radius=(1, 1, 1), Subsurface_Scale=0.025)
    node.subsurface_method = "RANDOM_WALK"
    bpy.ops.mesh.primitive_monkey_add(size=0.075, location=(-0.085, 0, 0.036), rotation=(math.radians(-12), 0, math.radians(20)))
    monkey = put(bpy.context.object, jade)
    # Her eyes are sheets with open edges, and a medium needs an inside.
    remesh = monkey.modifiers.new("remesh", "REMESH")
    remesh.mode, remesh.voxel_size, remesh.use_smooth_shade = "VOXEL", 0.0016, True
    smooth = monkey.modifiers.new("smooth", "SMOOTH")
    smooth.factor, smooth.iterations = 0.5, 6

    glass, _ = material("glass", Base_Color=(1, 1, 1), Roughness=0, IOR=1.5, Transmission_Weight=1)
    tea, _ = material("tea", Base_Color=(1, 1, 1), Roughness=0, IOR=1.33, Transmission_Weight=1)
    volume = tea.node_tree.nodes.new("ShaderNodeVolumeAbsorption")
    volume.inputs["Color"].default_value, volume.inputs["Density"].default_value = (0.9, 0.55, 0.1, 1), 60
    tea.node_tree.links.new(volume.outputs[0], tea.node_tree.get_output_node("CYCLES").inputs["Volume"])
    wall = [(0, 0), (24, 0), (28, 74), (25.6, 74), (21.8, 7), (0, 7)]
    lathe("tumbler", rounded([(r * MM, z * MM) for r, z in wall], 1.1 * MM), glass)
    inside = lambda z: 21.8 + (z - 7) * 3.8 / 67
    fill = [(0, 6.5), (inside(6.5) + 0.4, 6.5), (inside(52) + 0.4, 52), (0, 52)]
    lathe("tea", rounded([(r * MM, z * MM) for r, z in fill], 0.3 * MM), tea)

    skin, node = material("skin", Roughness=0.4, IOR=1.4, Subsurface_Weight=1, Subsurface_Radius=(1, 0.35, 0.2), Subsurface_Scale=0.03)
    node.subsurface_method = "RANDOM_WALK"
    texture = skin.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = face()
    skin.node_tree.links.new(texture.outputs["Color"], node.inputs["Base Color"])
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, radius=0.036, location=(0.085, 0, 0.0445))
    head = put(bpy.context.object, skin)
    head.scale = (0.88, 0.95, 1.2)
    head.rotation_euler = (0, 0, math.radians(-105))

    table, _ = material("table", Base_Color=(0.35, 0.3, 0.27), Roughness=0.7, Specular_IOR_Level=0.3)
    bpy.ops.mesh.primitive_plane_add(size=1.2)
    put(bpy.context.object, table, smooth=False)


def build():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.unit_settings.system = "METRIC"
    scene.render.resolution_x, scene.render.resolution_y = 480, 360
    bodies()
    light("sun", "SUN", (0, 0, 1), (-0.4, -0.45, 0.2), 0.9, angle=math.radians(8))
    light("spot", "SPOT", (0.35, -0.35, 0.45), (0.06, 0, 0.03), 9, spot_size=math.radians(35), spot_blend=0.3, shadow_soft_size=0.01)
    light("area", "AREA", (-0.35, 0.25, 0.3), (-0.03, 0, 0.04), 3.5, shape="RECTANGLE", size=0.3, size_y=0.2)
    world = bpy.data.worlds.new("world")
    scene.world, world.use_nodes = world, True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.2, 0.22, 0.25, 1)
    data = bpy.data.cameras.new("camera")
    data.lens, data.clip_start = 60, 0.01
    camera = bpy.data.objects.new("camera", data)
    scene.collection.objects.link(camera)
    camera.location = (0.02, -0.46, 0.2)
    aim(camera, (0, 0, 0.033))
    scene.camera = camera


def cycles(path, samples=256, threads=0):
    """Renders with Cycles, nothing clamped and no path cut short, shown by the view transform Standard."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.filepath = path
    if path.endswith(".exr"):
        scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    if threads:
        scene.render.threads_mode, scene.render.threads = "FIXED", threads
    scene.view_settings.view_transform = "Standard"
    c = scene.cycles
    c.samples, c.use_adaptive_sampling, c.use_denoising = samples, False, False
    c.sample_clamp_direct = c.sample_clamp_indirect = c.blur_glossy = 0
    c.max_bounces = c.diffuse_bounces = c.glossy_bounces = c.transmission_bounces = c.volume_bounces = c.transparent_max_bounces = 64
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    build()
    if "--cycles" in sys.argv:
        at = sys.argv.index("--cycles")
        cycles(os.path.abspath(sys.argv[at + 1]), *map(int, sys.argv[at + 2:]))
    else:
        commands, notes = to_nephrite.export(os.path.join(HERE, "exported.glb"))
        print("\n".join([*commands, *(f"# {note}" for note in notes)]))
