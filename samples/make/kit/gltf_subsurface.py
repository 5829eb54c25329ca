"""NEPHRITE_materials_subsurface for Blender's own glTF exporter, through its hook for user extensions.

A material carries the medium in a custom property and, where coefficients are textured, in a node group whose inputs
the image textures are linked to. The hook writes the extension and the fallback that its specification recommends.
"""
import json
import math
import sys

import bpy

NAME = "NEPHRITE_materials_subsurface"
PROPERTY = "nephrite_subsurface"
GROUP = "NEPHRITE subsurface"
TEXTURE_INPUTS = {"Absorption": "absorptionTexture", "Scattering": "scatteringTexture"}


def attach(material, medium, thickness):
    """Gives the Blender material a medium; `thickness` (metres) is what rasterisers assume of a clear one."""
    values = {"absorptionCoefficient": medium.absorption, "scatteringCoefficient": medium.scattering,
              "scatterAnisotropy": medium.anisotropy, "ior": medium.ior}
    if medium.density != 1.0:
        values["densityFactor"] = medium.density
    if medium.priority:
        values["priority"] = medium.priority
    material[PROPERTY] = json.dumps({"values": values, "extinction": medium.extinction, "thickness": thickness})


def link_texture(material, coefficient, image):
    """Multiplies a coefficient ("Absorption" or "Scattering") by an image of linear data."""
    tree = material.node_tree
    group = bpy.data.node_groups.get(GROUP)
    if group is None:
        group = bpy.data.node_groups.new(GROUP, "ShaderNodeTree")
        for name in TEXTURE_INPUTS:
            group.interface.new_socket(name, in_out="INPUT", socket_type="NodeSocketColor")
    node = next((n for n in tree.nodes if n.type == "GROUP" and n.node_tree == group), None)
    if node is None:
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = group
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    tree.links.new(texture.outputs["Color"], node.inputs[coefficient])


def multiscatter_albedo(single, anisotropy):
    """The multi-scatter albedo that stands for a single-scattering albedo in KHR_materials_scatter."""
    s = math.sqrt((1 - single) / (1 - anisotropy * single))
    return (1 - s) * (1 - 0.139 * s) / (1 + 1.17 * s)


def fallback(values, extinction, thickness):
    """Other extensions that describe the same medium, as far as they can."""
    significant = lambda v: float(f"{v:.6g}")
    out = {"KHR_materials_ior": {"ior": values["ior"]}, "KHR_materials_transmission": {"transmissionFactor": 1}}
    scatters = max(values["scatteringCoefficient"]) > 0
    if max(extinction) == 0:
        out["KHR_materials_volume"] = {"thicknessFactor": significant(thickness)}
        return out
    distance = 1 / max(extinction)
    out["KHR_materials_volume"] = {
        "thicknessFactor": significant(distance / 4 if scatters else thickness),
        "attenuationDistance": significant(distance),
        "attenuationColor": [significant(math.exp(-t * distance)) for t in extinction],
    }
    if scatters:
        density = values.get("densityFactor", 1.0)
        single = [density * s / t for s, t in zip(values["scatteringCoefficient"], extinction)]
        out["KHR_materials_scatter"] = {
            "scatterStrengthFactor": 1,
            "multiscatterColorFactor": [significant(multiscatter_albedo(a, values["scatterAnisotropy"])) for a in single],
            "scatterAnisotropy": values["scatterAnisotropy"],
        }
    return out


class glTF2ExportUserExtension:
    """Found by the exporter under exactly this name."""

    def __init__(self):
        from io_scene_gltf2.io.com.gltf2_io_extensions import Extension

        self.wrap = lambda name, body: Extension(name=name, extension=body, required=False)

    def gather_material_hook(self, gltf2_material, blender_material, export_settings):
        if blender_material is None or PROPERTY not in blender_material:
            return
        stored = json.loads(blender_material[PROPERTY])
        body = dict(stored["values"])
        for coefficient, key in TEXTURE_INPUTS.items():
            info = self.texture_info(blender_material, coefficient, export_settings)
            if info is not None:
                body[key] = info
        gltf2_material.extensions = gltf2_material.extensions or {}
        parts = {NAME: body} | fallback(stored["values"], stored["extinction"], stored["thickness"])
        for name, part in parts.items():
            gltf2_material.extensions[name] = self.wrap(name, part)
        gltf2_material.extras = None

    def texture_info(self, material, coefficient, export_settings):
        from io_scene_gltf2.blender.exp.material.search_node_tree import NodeSocket
        from io_scene_gltf2.blender.exp.material.texture_info import gather_texture_info

        for node in material.node_tree.nodes:
            if node.type == "GROUP" and node.node_tree.name == GROUP and node.inputs[coefficient].is_linked:
                socket = NodeSocket(node.inputs[coefficient], [material.node_tree])
                return gather_texture_info(socket, (socket,), export_settings)[0]
        return None


def register():
    """Makes the exporter find this module, as it finds an add-on that the user has enabled."""
    sys.modules[NAME] = sys.modules[__name__]
    if NAME not in bpy.context.preferences.addons:
        bpy.context.preferences.addons.new().module = NAME
