"""Writes the scene through Blender's own glTF exporter, with the extension's hook."""
import os

import bpy

from . import gltf_subsurface


def write(path, copyright):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    gltf_subsurface.register()
    bpy.ops.export_scene.gltf(
        filepath=path, export_format="GLB", export_yup=True, export_apply=True, export_cameras=True, export_lights=True,
        export_animations=False, export_skins=False, export_morph=False, export_materials="EXPORT", export_image_format="AUTO",
        export_import_convert_lighting_mode="SPEC", export_extras=False, export_copyright=copyright)
