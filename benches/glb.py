"""GLB files in the making, for scenes that scripts write."""
import array, json, struct

MEDIUM = {"absorptionCoefficient": [1, 1, 1], "scatteringCoefficient": [100, 100, 100], "ior": 1.3}
SUBSURFACE = {"pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": {"NEPHRITE_materials_subsurface": MEDIUM}}
EXTENSIONS = ["NEPHRITE_materials_subsurface", "KHR_materials_transmission", "KHR_materials_variants", "KHR_lights_punctual",
              "EXT_mesh_gpu_instancing", "KHR_texture_transform", "KHR_animation_pointer"]


class File:
    """A glTF file in the making."""

    def __init__(self):
        self.bytes = bytearray()
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [],
                     "accessors": [], "bufferViews": [], "materials": []}

    def add(self, what, value):
        """Appends to a list of the file; its number."""
        rows = self.json.setdefault(what, [])
        rows.append(value)
        return len(rows) - 1

    def view(self, data):
        self.bytes += bytes(-len(self.bytes) % 4)
        view = self.add("bufferViews", {"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data)})
        self.bytes += data
        return view

    def floats(self, values, kind="VEC3"):
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}[kind]
        accessor = {"bufferView": self.view(array.array("f", values).tobytes()), "componentType": 5126, "count": len(values) // width, "type": kind}
        if width in (1, 3):
            accessor["min"] = [struct.unpack("f", struct.pack("f", min(values[i::width])))[0] for i in range(width)]
            accessor["max"] = [struct.unpack("f", struct.pack("f", max(values[i::width])))[0] for i in range(width)]
        return self.add("accessors", accessor)

    def primitive(self, positions, indices, material, **attributes):
        view = self.view(array.array("I", indices).tobytes())
        numbers = self.add("accessors", {"bufferView": view, "componentType": 5125, "count": len(indices), "type": "SCALAR"})
        return {"attributes": {"POSITION": self.floats(positions), **attributes}, "indices": numbers, "material": material}

    def mesh(self, positions, indices, material=SUBSURFACE):
        return self.add("meshes", {"primitives": [self.primitive(positions, indices, self.add("materials", material))]})

    def place(self, **node):
        number = self.add("nodes", node)
        self.json["scenes"][0]["nodes"].append(number)
        return number

    def lamp(self, light, **node):
        self.place(extensions={"KHR_lights_punctual": {"light": light}}, **node)

    def write(self, path):
        root = self.json
        text = json.dumps(root)
        root["extensionsUsed"] = [e for e in EXTENSIONS if f'"{e}"' in text]
        root = {k: v for k, v in root.items() if v}
        self.bytes += bytes(-len(self.bytes) % 4)
        if self.bytes:
            root["buffers"] = [{"byteLength": len(self.bytes)}]
        text = json.dumps(root).encode()
        text += b" " * (-len(text) % 4)
        total = 12 + 8 + len(text) + (8 + len(self.bytes) if self.bytes else 0)
        with open(path, "wb") as f:
            f.write(struct.pack("<4sIIII", b"glTF", 2, total, len(text), 0x4E4F534A) + text)
            if self.bytes:
                f.write(struct.pack("<II", len(self.bytes), 0x004E4942) + self.bytes)
