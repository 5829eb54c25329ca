"""Makes the samples: python3 samples/make/build.py --meshes DIR [NAME ...]

Needs Blender's Python module (bpy 5.0 from PyPI) and NumPy, and for three of the samples a folder with the meshes that
samples/README.md names. Each sample is a module of this folder with a function `build(meshes)` that fills the scene.
"""
import argparse
import importlib
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
NAMES = {"nefertiti": "nefertiti", "jade-knot": "jade_knot", "milk-in-glass": "milk_in_glass", "amber": "amber",
         "candy-cow": "candy_cow", "gummy-fish": "gummy_fish", "still-life": "still_life", "tin-robot": "tin_robot"}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("names", nargs="*", choices=[*NAMES, []], default=[])
    parser.add_argument("--meshes", required=True, help="folder with the public-domain meshes")
    parser.add_argument("--out", default=os.path.dirname(HERE), help="folder that gets a folder for each sample")
    arguments = parser.parse_args()

    from kit import check, export, studio

    for name in arguments.names or NAMES:
        studio.reset()
        module = importlib.import_module(NAMES[name])
        module.build(arguments.meshes)
        path = os.path.join(arguments.out, name, name + ".glb")
        export.write(path, module.COPYRIGHT)
        check.report(path)


if __name__ == "__main__":
    main()
