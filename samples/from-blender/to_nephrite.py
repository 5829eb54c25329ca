"""Exports a Blender scene for nephrite, and prints the commands that give its materials their media.

    blender -b scene.blend --python to_nephrite.py -- scene.glb
    python3 to_nephrite.py scene.blend scene.glb              # with the module bpy of PyPI

or, in Blender's text editor, Run Script: it then writes beside the .blend file. Blender 4.2 to 4.5; the scene is left as
it was. docs/from-blender.md says why each step is as it is, and against what it was checked.

What has a size in Cycles and none in KHR_lights_punctual becomes a mesh that shines: area lights, points with a radius,
suns with an angle. Spots get a cone of the same power. Everything else goes through Blender's own exporter.
"""
import json
import math
import os
import shlex
import struct
import sys

import bpy
from mathutils import Matrix, Vector

SUN_DISTANCE = 100.0   # of the disc that stands for a sun, in radii of the scene: 1/100 is far below any penumbra's width

# ---------------------------------------------------------------------------------------------------------- subsurface

# What Cycles 4.5 shows of a base colour: flat body, uniform light, straight on, without the reflection of its surface.
# Measured. Its walks end after 256 events, and what they carry then is lost: so nothing is above 0.91.
BASE = [0, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.95, 1]
SHOWN = {   # by anisotropy
    "RANDOM_WALK": {
        0: [0, 0.078, 0.161, 0.296, 0.442, 0.599, 0.770, 0.880, 0.896, 0.896],
        0.5: [0, 0.060, 0.137, 0.271, 0.423, 0.593, 0.800, 0.897, 0.897, 0.897],
        0.8: [0, 0.053, 0.130, 0.277, 0.441, 0.629, 0.904, 0.904, 0.904, 0.904],
    },
    "RANDOM_WALK_SKIN": {0: [0, 0.091, 0.184, 0.328, 0.475, 0.626, 0.795, 0.893, 0.908, 0.908]},
    "BURLEY": {0: BASE},
}
# By how much a mean free path carries light farther below a boundary of index n than without one, for a seen colour C:
# the ratio of the diffusion lengths of the two media that show C.
COLOR = [0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1]
FARTHER = {
    1.0: [1] * 11,
    1.2: [1, 1.06, 1.16, 1.22, 1.25, 1.28, 1.29, 1.30, 1.31, 1.31, 1.31],
    1.33: [1, 1.12, 1.28, 1.38, 1.45, 1.50, 1.53, 1.56, 1.57, 1.58, 1.59],
    1.4: [1, 1.15, 1.35, 1.48, 1.57, 1.63, 1.68, 1.71, 1.73, 1.75, 1.76],
    1.5: [1, 1.20, 1.46, 1.63, 1.75, 1.84, 1.90, 1.95, 1.98, 2.01, 2.03],
    1.6: [1, 1.26, 1.58, 1.80, 1.95, 2.06, 2.14, 2.21, 2.26, 2.30, 2.32],
}
# Christensen–Burley spreads light alike whatever the colour. Mean free path, in Radius/4π, of the walk of Cycles that
# darkens as far behind the edge of a shadow, at a tenth of the light.
BURLEY_FREE = ([0, 0.25, 0.55, 0.825, 1], [3, 2.34, 1.45, 0.84, 0.5])


def between(x, xs, ys):
    """ys at x, linear between the xs."""
    if x <= xs[0]:
        return ys[0]
    x = min(x, xs[-1])
    for i in range(1, len(xs)):
        if x <= xs[i]:
            return ys[i - 1] + (ys[i] - ys[i - 1]) * (x - xs[i - 1]) / (xs[i] - xs[i - 1])


def farther(color, ior):
    return between(ior, list(FARTHER), [between(color, COLOR, row) for row in FARTHER.values()])


def skin_factor(base, ior):
    """Random Walk (Skin) takes Radius for a diffuse mean free path and inverts the dipole of Jensen et al. 2001 for the
    albedo: its mean free path is this times Radius."""
    fdr = -1.44 / ior ** 2 + 0.71 / ior + 0.668 + 0.0636 * ior
    a = (1 + fdr) / (1 - fdr)
    low, high = 0.0, 1.0
    for _ in range(12):   # as many steps as Cycles takes: they bound the result for white
        middle = (low + high) / 2
        root = math.sqrt(3 * (1 - middle))
        if middle / 2 * (1 + math.exp(-4 / 3 * a * root)) * math.exp(-root) < base:
            low = middle
        else:
            high = middle
    return math.sqrt(3 * (1 - middle))


def medium(base, radius, method, ior, skin_ior, g):
    """Seen colour, and mean free path in metres, of one channel: what nephrite needs to show what Cycles shows."""
    shown = SHOWN[method]
    color = between(g, list(shown), [between(base, BASE, row) for row in shown.values()])
    if method == "RANDOM_WALK":
        free = radius / (4 * math.pi)
    elif method == "RANDOM_WALK_SKIN":
        free = radius * skin_factor(base, skin_ior)
    else:
        free = radius / (4 * math.pi) * between(color, *BURLEY_FREE)
    return color, free * (1 - g) / farther(color, ior)


# ----------------------------------------------------------------------------------------------------------- materials

def active(material, kind, socket):
    """The node of a kind (None: any) that a socket of the active output is linked to."""
    if not material.use_nodes:
        return None
    output = material.node_tree.get_output_node("CYCLES") or material.node_tree.get_output_node("ALL")
    links = output.inputs[socket].links if output else ()
    return next((l.from_node for l in links if kind is None or l.from_node.type in kind), None)


def image_mean(node):
    """Mean of an image in linear light; Blender's pixels are encoded as the file has them."""
    image = node.image
    values = list(image.pixels)
    if not values:
        return None
    step = image.channels * max(1, len(values) // image.channels // 20000)
    linear = lambda v: v if image.colorspace_settings.is_data else (v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4)
    sums = [sum(linear(v) for v in values[c::step]) for c in range(3)]
    return [s / len(values[0::step]) for s in sums]


def triple(values):
    """Three numbers for the command line."""
    words = [f"{v:.4g}" for v in values]
    return words[0] if len(set(words)) == 1 else ",".join(words)


def subsurface_command(material, notes):
    p = active(material, ("BSDF_PRINCIPLED",), "Surface")
    if p is None or p.inputs["Subsurface Weight"].default_value <= 0:
        return None
    value = lambda name, other=None: p.inputs[name].default_value if name in p.inputs else other
    weight, method, ior, g = value("Subsurface Weight"), p.subsurface_method, value("IOR"), value("Subsurface Anisotropy", 0.0)
    g = 0.0 if method == "BURLEY" else min(max(g, 0.0), 0.9)
    if weight < 1:
        notes.append(f'{material.name}: Subsurface Weight {weight:.2g} mixes with a matte surface in Cycles; the medium is all of it here')
    for name in ("Subsurface Weight", "Subsurface Radius", "Subsurface Scale", "Subsurface Anisotropy", "IOR"):
        if name in p.inputs and p.inputs[name].is_linked:
            notes.append(f"{material.name}: what {name} is linked to is not read, but the number behind it")
    base, painted = value("Base Color")[:3], False
    if p.inputs["Base Color"].is_linked:
        node = p.inputs["Base Color"].links[0].from_node
        painted = node.type == "TEX_IMAGE" and node.image is not None
        if painted:
            base = image_mean(node)
            if base is None:
                notes.append(f"{material.name}: its image {node.image.name} is missing")
                base = (0.5, 0.5, 0.5)
        else:
            notes.append(f"{material.name}: bake what its Base Color is linked to into an image")
    channels = [medium(b, r * value("Subsurface Scale"), method, ior, value("Subsurface IOR", 1.4), g)
                for b, r in zip(base, value("Subsurface Radius"))]
    words = ["--color", triple(c for c, _ in channels)] if not painted else ["--from-base-color"]
    words += ["--unit", "mm", "--mean-free-path", triple(1000 * f for _, f in channels), "--ior", f"{ior:.4g}"]
    words += ["--anisotropy", f"{g:.3g}"] if g else []
    return words + ([] if painted else ["--fix-surface"])


def clear_command(material, notes):
    """Glass, and liquids whose colour is a volume."""
    p = active(material, ("BSDF_PRINCIPLED",), "Surface")
    if p is None:
        if material.use_nodes:
            notes.append(f"{material.name}: its surface is not a Principled BSDF, and is exported as bare metal")
        return None
    if p.inputs["Transmission Weight"].default_value < 1:
        return None
    absorption, scattering, g = [0.0] * 3, [0.0] * 3, 0.0
    v = active(material, ("VOLUME_ABSORPTION", "VOLUME_SCATTER", "VOLUME_COEFFICIENTS"), "Volume")
    if v is not None and v.type == "VOLUME_ABSORPTION":
        absorption = [v.inputs["Density"].default_value * (1 - c) for c in v.inputs["Color"].default_value[:3]]
    elif v is not None and v.type == "VOLUME_SCATTER":
        scattering = [v.inputs["Density"].default_value * c for c in v.inputs["Color"].default_value[:3]]
        g = v.inputs["Anisotropy"].default_value
    elif v is not None:
        absorption, scattering = v.inputs["Absorption Coefficients"].default_value, v.inputs["Scatter Coefficients"].default_value
        g = v.inputs["Anisotropy"].default_value
    elif active(material, None, "Volume") is not None:
        notes.append(f"{material.name}: only Volume Absorption, Scatter and Coefficients are read; type --absorption and --scattering")
    if min(p.inputs["Base Color"].default_value[:3]) < 0.999:
        notes.append(f"{material.name}: its colour tints at each crossing of the surface, as in Cycles")
    words = ["--absorption", triple(absorption), "--scattering", triple(scattering), "--ior", f'{p.inputs["IOR"].default_value:.4g}']
    return words + (["--anisotropy", f"{g:.3g}"] if g else [])


# -------------------------------------------------------------------------------------------------------------- lights

def tint(light):
    color = list(light.color)
    if getattr(light, "use_temperature", False):
        color = [c * t for c, t in zip(color, light.temperature_color)]
    return [c * 2 ** getattr(light, "exposure", 0) for c in color]


def shining(name, vertices, faces, matrix, radiance):
    """A mesh that emits from its front, visible in the export only."""
    material = bpy.data.materials.new(name)
    material.use_nodes = material.use_backface_culling = True
    inputs = next(n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED").inputs
    strength = max(radiance)
    inputs["Base Color"].default_value = (0, 0, 0, 1)
    inputs["Roughness"].default_value, inputs["Specular IOR Level"].default_value = 1, 0
    inputs["Emission Color"].default_value = (*(c / strength for c in radiance), 1)
    inputs["Emission Strength"].default_value = strength
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    mesh.materials.append(material)
    item = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(item)
    item.matrix_world = matrix
    return item


def disc(radius_x, radius_y, n=48):
    """Facing −Z, as lights do, and with the area of the ellipse."""
    grow = math.sqrt(2 * math.pi / n / math.sin(2 * math.pi / n))
    radius_x, radius_y = grow * radius_x, grow * radius_y
    angles = [2 * math.pi * i / n for i in range(n)]
    return [(radius_x * math.cos(t), radius_y * math.sin(t), 0) for t in angles], [tuple(reversed(range(n)))]


def ball(radius, n=24):
    """With the area of the sphere, so that the power is that of the light."""
    angles = [math.pi * j / (n // 2) for j in range(n // 2 + 1)]
    rings = [(math.sin(t), math.cos(t)) for t in angles]
    # A ring of trapezoids between two parallels; chords are shorter than arcs.
    area = sum(n * math.sin(math.pi / n) * (r + q) * math.hypot((q - r) * math.cos(math.pi / n), z - y)
               for (r, z), (q, y) in zip(rings, rings[1:]))
    radius *= math.sqrt(4 * math.pi / area)
    around = [(math.cos(2 * math.pi * i / n), math.sin(2 * math.pi * i / n)) for i in range(n)]
    rows = rings[1:-1]
    vertices = [(radius * r * x, radius * r * y, radius * z) for r, z in rows for x, y in around]
    vertices = [(0, 0, radius), *vertices, (0, 0, -radius)]
    at = lambda j, i: 1 + j * n + i % n
    last = len(rows) - 1
    faces = [(0, at(0, i), at(0, i + 1)) for i in range(n)] + [(len(vertices) - 1, at(last, i + 1), at(last, i)) for i in range(n)]
    return vertices, faces + [(at(j, i), at(j + 1, i), at(j + 1, i + 1), at(j, i + 1)) for j in range(last) for i in range(n)]


def rendered(item):
    """Whether the exporter takes it for renderable."""
    return not item.hide_render and not all(c.hide_render for c in item.users_collection)


def bounds():
    corners = [o.matrix_world @ Vector(c) for o in bpy.context.scene.objects if o.type == "MESH" and rendered(o) for c in o.bound_box]
    if not corners:
        return Vector(), 1.0
    low, high = (Vector(f(c[i] for c in corners) for i in range(3)) for f in (min, max))
    return (low + high) / 2, max((high - low).length / 2, 1e-6)


def spot_blend(light):
    """The blend with which the exported cone has the flux of Cycles': there light fades with smoothstep of the cosine over
    the share `blend` of the cone, in KHR_lights_punctual with the square of a ramp, of which 1/3 is left instead of 1/2."""
    half = light.spot_size / 2
    cosine = math.cos(half)
    return 1 - math.acos(min(cosine + 0.75 * light.spot_blend * (1 - cosine), 1)) / half


def light_mesh(item, matrix, notes):
    """What stands for a light that has a size; None where KHR_lights_punctual says all."""
    light = item.data
    colour, name, rigid = tint(light), f"light {item.name}", matrix.normalized()
    energy = light.energy
    if max(colour) * energy <= 0:
        return None
    if light.type == "AREA":
        square = light.shape in ("SQUARE", "DISK")
        scale = matrix.to_scale()
        x, y = light.size * scale.x / 2, (light.size if square else light.size_y) * scale.y / 2
        round_ = light.shape in ("DISK", "ELLIPSE")
        area = (math.pi if round_ else 4) * x * y
        # Lambert's lamp of P watts and area A has radiance P/(πA).
        radiance = [c * energy / (math.pi * (area if getattr(light, "normalize", True) else 1)) for c in colour]
        if light.spread < math.pi * 0.999:
            notes.append(f"{item.name}: the spread of an area light is lost")
        shape = disc(x, y) if round_ else ([(-x, -y, 0), (-x, y, 0), (x, y, 0), (x, -y, 0)], [(0, 1, 2, 3)])
        return shining(name, *shape, rigid, radiance)
    if light.type == "SUN" and light.angle > 0:
        center, radius = bounds()
        half = min(light.angle / 2, math.radians(80))
        distance = SUN_DISTANCE * radius
        place = Matrix.Translation(center + rigid.to_3x3() @ Vector((0, 0, distance))) @ rigid.to_3x3().to_4x4()
        # A disc of radiance L over the half angle θ makes the irradiance πL sin²θ.
        return shining(name, *disc(*[distance * math.tan(half)] * 2), place, [c * energy / (math.pi * math.sin(half) ** 2) for c in colour])
    if light.type == "POINT" and light.shadow_soft_size > 0:
        r = light.shadow_soft_size
        return shining(name, *ball(r), rigid, [c * energy / (4 * math.pi ** 2 * r * r) for c in colour])
    if light.type == "SPOT" and light.shadow_soft_size > 0:
        notes.append(f"{item.name}: the radius of a spot is lost, its shadows are sharp")
    return None


# --------------------------------------------------------------------------------------------------------------- scene

def world(notes):
    """What to type for the world."""
    item = bpy.context.scene.world
    node = next((n for n in item.node_tree.nodes if n.type == "BACKGROUND"), None) if item and item.use_nodes else None
    if node is None:
        return ["--env", "none"]
    strength, socket = node.inputs["Strength"].default_value, node.inputs["Color"]
    if not socket.is_linked:
        color = [strength * c for c in socket.default_value[:3]]
        return ["--env", triple(color) if max(color) > 0 else "none"]
    node = socket.links[0].from_node
    if node.type != "TEX_ENVIRONMENT" or node.image is None or node.image.packed_file:
        notes.append("the world is neither a colour nor an image file: bake it into an equirectangular .hdr or .exr for --env")
        return ["--env", "none"]
    words = ["--env", bpy.path.abspath(node.image.filepath), "--env-intensity", f"{strength:.4g}"]
    links = node.inputs["Vector"].links
    if links and links[0].from_node.type == "MAPPING":
        # Blender turns the vector that looks the image up, nephrite the image.
        words += ["--env-rotation", f"{-math.degrees(links[0].from_node.inputs['Rotation'].default_value[2]):.4g}"]
    return words


def lens(notes):
    camera = bpy.context.scene.camera
    if camera is None:
        return
    if camera.data.dof.use_dof:
        notes.append("depth of field is lost")
    if camera.data.type == "PANO":
        notes.append("panoramic cameras are not exported")


def exported_materials(path):
    """Names of the materials in a .glb, also those that geometry nodes set."""
    with open(path, "rb") as file:
        file.seek(12)
        length, _ = struct.unpack("<II", file.read(8))
        return [m.get("name") for m in json.loads(file.read(length)).get("materials", [])]


def export(path):
    """Writes the .glb, and returns the commands and what is lost."""
    notes, made, hidden, blends = [], [], [], {}
    bpy.context.view_layer.update()
    lights = [(o, o.matrix_world.copy(), False) for o in bpy.context.scene.objects if o.type == "LIGHT"]
    lights += [(i.object.original, i.matrix_world.copy(), True) for i in bpy.context.evaluated_depsgraph_get().object_instances
               if i.is_instance and i.object.type == "LIGHT"]
    for item, matrix, instance in lights:
        if not rendered(item):
            continue
        if instance and item.data.type != "AREA":
            continue   # the exporter writes it as a light without size, and it cannot be hidden by itself
        if item.data.type == "SPOT" and item.data not in blends:
            blends[item.data] = item.data.spot_blend
            item.data.spot_blend = spot_blend(item.data)
        mesh = light_mesh(item, matrix, notes)
        if mesh is not None:
            made.append(mesh)
            if not instance:
                item.hide_render = True
                hidden.append(item)
    try:
        bpy.ops.export_scene.gltf(
            filepath=path, export_format="GLB", use_renderable=True, export_yup=True, export_apply=True, export_cameras=True,
            export_lights=True, export_import_convert_lighting_mode="COMPAT", export_materials="EXPORT", export_normals=True,
            export_texcoords=True, export_animations=False, export_current_frame=True)
    finally:
        for light, blend in blends.items():
            light.spot_blend = blend
        for item in hidden:
            item.hide_render = False
        for item in made:
            data = item.data
            material = data.materials[0]
            bpy.data.objects.remove(item)
            bpy.data.meshes.remove(data)
            bpy.data.materials.remove(material)
    lens(notes)
    name, commands = os.path.basename(path), []
    found = (bpy.data.materials.get(name) for name in exported_materials(path))
    for material in sorted({m for m in found if m is not None}, key=lambda m: m.name):
        words = subsurface_command(material, notes) or clear_command(material, notes)
        if words is not None:
            commands.append(shlex.join(["nephrite", "edit", name, "--in-place", "--material", material.name, *words]))
    picture = os.path.splitext(name)[0] + ".png"
    commands.append(shlex.join(["nephrite", "render", name, "-o", picture, *world(notes), "--tonemap", "linear"]))
    return commands, notes


def main():
    arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [a for a in sys.argv[1:] if a.endswith((".blend", ".glb"))]
    for blend in [a for a in arguments if a.endswith(".blend")][:1]:
        bpy.ops.wm.open_mainfile(filepath=os.path.abspath(blend))
    path = next((a for a in arguments if a.endswith(".glb")), os.path.splitext(bpy.data.filepath or "scene.blend")[0] + ".glb")
    commands, notes = export(os.path.abspath(path))
    print("\n".join([*commands, *(f"# {note}" for note in notes)]))


if __name__ == "__main__":
    main()
