"""Scenes of one extreme each, that grow with n, for extremes.py: `extreme_scenes.py NAME N FILE` writes one as a GLB file."""
import array, json, math, random, struct, sys

MEDIUM = {"absorptionCoefficient": [1, 1, 1], "scatteringCoefficient": [100, 100, 100], "ior": 1.3}
SUBSURFACE = {"pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": {"NEPHRITE_materials_subsurface": MEDIUM}}
GLASS = {"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0}, "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}}
BLEND = {"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.01]}}
LAMP = {"emissiveFactor": [1, 1, 1]}
PLAIN = {}
CUBE = ([float(c) for x in (0, 1) for y in (0, 1) for z in (0, 1) for c in (x, y, z)],
        [0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3])
TRIANGLE = ([0.0, 0, 0, 1, 0, 0, 0, 1, 0], [0, 1, 2])


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


EXTENSIONS = ["NEPHRITE_materials_subsurface", "KHR_materials_transmission", "KHR_materials_variants", "KHR_lights_punctual",
              "EXT_mesh_gpu_instancing", "KHR_texture_transform", "KHR_animation_pointer"]
SCENES = {}


def scene(n, what):
    def register(fill):
        def make(path, count):
            file = File()
            fill(file, count)
            file.write(path)
        SCENES[fill.__name__.replace("_", "-")] = (n, what, make)
        return fill
    return register


def empty(path):
    file = File()
    file.place(mesh=file.mesh(*TRIANGLE, PLAIN))
    file.write(path)


def grid(n, step=2.0):
    """n places of a cubic lattice."""
    k = max(1, math.ceil(n ** (1 / 3)))
    return [[step * (i % k), step * (i // k % k), step * (i // k // k)] for i in range(n)]


def one(file, positions, indices, material=SUBSURFACE):
    file.place(mesh=file.mesh(positions, indices, material))


# Triangles of one mesh


@scene(40_000, "triangles in one place")
def coincident_triangles(file, n):
    one(file, TRIANGLE[0], TRIANGLE[1] * n)


@scene(40_000, "triangles of one place that share no vertex")
def coincident_copies(file, n):
    one(file, TRIANGLE[0] * n, list(range(3 * n)))


@scene(40_000, "triangles that are all one point")
def points(file, n):
    one(file, [1.0, 2.0, 3.0] * 3, [0, 1, 2] * n)


@scene(40_000, "triangles on one line")
def line(file, n):
    one(file, [c for i in range(n + 2) for c in (float(i), 0.0, 0.0)], [j for i in range(n) for j in (i, i + 1, i + 2)])


@scene(1_000, "pages that share an edge")
def pages(file, n):
    around = [c for i in range(n) for c in (math.cos(math.tau * i / n), math.sin(math.tau * i / n), 0.5)]
    one(file, [0.0, 0, 0, 0, 0, 1] + around, [j for i in range(n) for j in (0, 1, 2 + i)])


@scene(1_000, "pages of two sides that share an edge")
def wedges(file, n):
    around = [c for i in range(n) for z in (0.0, 1.0) for c in (math.cos(math.tau * i / n), math.sin(math.tau * i / n), z)]
    faces = [j for i in range(n) for a, b in [(2 + 2 * i, 3 + 2 * i)] for j in (0, 1, a, 1, b, a, 1, 0, a, 1, a, b)]
    one(file, [0.0, 0, 0, 0, 0, 1] + around, faces)


@scene(40_000, "triangles around two points: a closed double cone")
def spindle(file, n):
    around = [c for i in range(n) for c in (math.cos(math.tau * i / n), math.sin(math.tau * i / n), 0.0)]
    faces = [j for i in range(n) for j in (0, 2 + i, 2 + (i + 1) % n, 1, 2 + (i + 1) % n, 2 + i)]
    one(file, [0.0, 0, 1, 0, 0, -1] + around, faces)


@scene(20_000, "triangles without order or neighbours")
def soup(file, n):
    r = random.Random(2)
    positions = []
    for _ in range(n):
        c = [r.random() for _ in range(3)]
        positions += [x + 0.1 * r.random() for _ in range(3) for x in c]
    one(file, positions, list(range(3 * n)))


@scene(20_000, "needles across the whole body")
def needles(file, n):
    r = random.Random(3)
    positions = []
    for _ in range(n):
        a, b = ([r.gauss(0, 1) for _ in range(3)] for _ in range(2))
        positions += a + b + [x + 1e-4 for x in b]
    one(file, positions, list(range(3 * n)), PLAIN)


def tetrahedra(places):
    positions, faces = [], []
    for x, y, z, s in places:
        b = len(positions) // 3
        positions += [x, y, z, x + s, y, z, x, y + s, z, x, y, z + s]
        faces += [b + i for i in (0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3)]
    return positions, faces


@scene(10_000, "bodies of one mesh, apart and across each other")
def solids(file, n):
    r = random.Random(4)
    one(file, *tetrahedra((10 * r.random(), 10 * r.random(), 10 * r.random(), 0.5 * r.random()) for _ in range(n)))


@scene(500, "bodies of one mesh, each within the one before")
def nested_parts(file, n):
    positions = [(1 + k / n) * (c - 0.5) for k in range(n) for c in CUBE[0]]
    one(file, positions, [8 * k + i for k in range(n) for i in CUBE[1]])


@scene(40_000, "small triangles beside one of a million times their size")
def small_and_large(file, n):
    positions = [c for x, y, z in grid(n) for c in (x, y, z, x + 0.1, y, z, x, y + 0.1, z)]
    one(file, positions + [-1e6, -1e6, -1, 1e6, -1e6, -1, 0, 1e6, -1], list(range(3 * n + 3)), PLAIN)


@scene(100_000, "vertices that nothing uses")
def unused_vertices(file, n):
    r = random.Random(5)
    one(file, TRIANGLE[0] + [r.random() for _ in range(3 * n)], TRIANGLE[1])


@scene(500, "vertices in one place, triangles between them and elsewhere")
def welded(file, n):
    positions = [c for i in range(n) for c in (0.0, 0, 0, math.cos(i), math.sin(i), 1, math.cos(i + 1), math.sin(i + 1), 1)]
    one(file, positions, list(range(3 * n)))


@scene(100, "rows and columns of a smooth body in a medium")
def sphere(file, n):
    n = round(10 * n ** 0.5)
    positions, faces = [0.0, 0, 1, 0, 0, -1], []
    at = lambda i, j: 0 if i == 0 else 1 if i == n else 2 + (i - 1) * n + j % n
    for i in range(1, n):
        for j in range(n):
            t, p = math.pi * i / n, math.tau * j / n
            positions += [math.sin(t) * math.cos(p), math.sin(t) * math.sin(p), math.cos(t)]
    for i in range(n):
        for j in range(n):
            a, b, c, d = at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)
            faces += [a, c, d] if i < n - 1 else []
            faces += [a, d, b] if i > 0 else []
    one(file, positions, faces)


@scene(2_000, "primitives of one mesh")
def primitives(file, n):
    material = file.add("materials", SUBSURFACE)
    rows = [file.primitive([c + o for c, o in zip(CUBE[0], p * 8)], CUBE[1], material) for p in grid(n)]
    file.place(mesh=file.add("meshes", {"primitives": rows}))


# Sheets one behind the other


def sheets(n, gap=1e-3):
    return [c for i in range(n) for c in (-9.0, -9, -gap * i, 9, -9, -gap * i, 0, 9, -gap * i)], list(range(3 * n))


@scene(500, "sheets of glass, one behind the other")
def panes(file, n):
    one(file, *sheets(n), GLASS)


@scene(1_000, "sheets of little coverage, one behind the other")
def veils(file, n):
    one(file, *sheets(n), BLEND)


@scene(500, "sheets of different materials in one place")
def layers(file, n):
    for i in range(n):
        one(file, *sheets(1), [SUBSURFACE, GLASS, BLEND, LAMP][i % 4])


# Instances


@scene(5_000, "bodies with a medium, apart")
def pebbles(file, n):
    mesh = file.mesh(*CUBE)
    for p in grid(n):
        file.place(mesh=mesh, translation=p)


@scene(5_000, "beans in a jar")
def beans(file, n):
    mesh = file.mesh(*CUBE)
    places = grid(n, 1.02)
    for p in places:
        file.place(mesh=mesh, translation=p)
    size = 2 + max(max(p) for p in places)
    file.place(mesh=file.mesh(*CUBE), translation=[-0.5] * 3, scale=[size] * 3)


@scene(5_000, "stretched bodies with a medium")
def stretched(file, n):
    mesh = file.mesh(*CUBE)
    for i, p in enumerate(grid(n)):
        file.place(mesh=mesh, translation=p, scale=[1.0, 1 + 0.5 * (i % 7) / 7, 1 - 0.5 * (i % 11) / 11])


@scene(50, "bodies, each within the next one")
def onion(file, n):
    mesh = file.mesh(*CUBE)
    for i in range(n):
        s = 1 + i / n
        file.place(mesh=mesh, scale=[s] * 3, translation=[-s / 2] * 3)


@scene(100, "bodies that all cross each other")
def crossing(file, n):
    mesh = file.mesh(*CUBE)
    r = random.Random(6)
    for _ in range(n):
        file.place(mesh=mesh, translation=[0.5 * r.random() for _ in range(3)])


@scene(2_000, "bodies in one place")
def coincident_bodies(file, n):
    mesh = file.mesh(*CUBE)
    for _ in range(n):
        file.place(mesh=mesh)


@scene(5_000, "bodies in a row, each across the next one")
def chain(file, n):
    mesh = file.mesh(*CUBE)
    for i in range(n):
        file.place(mesh=mesh, translation=[0.75 * i, 0.1 * (i % 2), 0.1 * (i % 3)])


@scene(2_000, "bodies of a mesh and a material each")
def own_meshes(file, n):
    for p in grid(n):
        file.place(mesh=file.mesh(*CUBE), translation=p)


@scene(20_000, "instances of one node (EXT_mesh_gpu_instancing)")
def gpu_instances(file, n):
    places = file.floats([c for p in grid(n) for c in p])
    file.place(mesh=file.mesh(*CUBE, PLAIN), extensions={"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}})


@scene(20_000, "nodes, each the child of the one before")
def deep_nodes(file, n):
    file.place(mesh=file.mesh(*CUBE, PLAIN))
    first = file.place(translation=[0.0, 0, 0.1])
    for i in range(n):
        file.json["nodes"][-1]["children"] = [first + i + 1]
        file.add("nodes", {"translation": [1e-5, 0, 0]})
    file.json["nodes"][-1]["mesh"] = 0


@scene(50_000, "nodes without anything")
def empty_nodes(file, n):
    file.place(mesh=file.mesh(*CUBE, PLAIN))
    for i in range(n):
        file.place(name=f"nothing {i}")


# Lights


def room(file):
    one(file, [-50.0, -50, -1, 50, -50, -1, 0, 90, -1], [0, 1, 2], PLAIN)


def lights(file, kind):
    file.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": kind, "intensity": 1.0}]}}


@scene(20_000, "lamps apart")
def lamps(file, n):
    room(file)
    lights(file, "point")
    for p in grid(n):
        file.lamp(0, translation=p)


@scene(20_000, "lamps in one place")
def coincident_lamps(file, n):
    room(file)
    lights(file, "point")
    for _ in range(n):
        file.lamp(0, translation=[0.0, 0, 3])


@scene(2_000, "suns")
def suns(file, n):
    room(file)
    lights(file, "directional")
    for i in range(n):
        file.lamp(0, rotation=[math.sin(i / n), 0, 0, math.cos(i / n)])


@scene(2_000, "lamps among bodies with a medium")
def lamps_and_bodies(file, n):
    pebbles(file, n)
    lights(file, "point")
    for p in grid(n):
        file.lamp(0, translation=[c + 1.5 for c in p])


@scene(500, "lamps within bodies, each within the next one")
def lamps_in_onion(file, n):
    onion(file, 20)
    lights(file, "point")
    for i in range(n):
        file.lamp(0, translation=[0.4 * i / n, 0.1, 0.2])


@scene(40_000, "triangles that emit")
def emitters(file, n):
    room(file)
    positions, faces = tetrahedra((*p, 0.5) for p in grid(n // 4))
    one(file, positions, faces, LAMP)


@scene(2_000, "bodies that emit among bodies with a medium")
def emitters_and_bodies(file, n):
    pebbles(file, n)
    mesh = file.mesh(*CUBE, LAMP)
    for p in grid(n):
        file.place(mesh=mesh, scale=[0.2] * 3, translation=[c + 1.5 for c in p])


@scene(10_000, "emitting triangles in one place")
def coincident_emitters(file, n):
    room(file)
    one(file, TRIANGLE[0], TRIANGLE[1] * n, LAMP)


# Materials, textures, motion, text


def png(side):
    import zlib
    rows = b"".join(b"\0" + bytes((x * y) & 255 for x in range(side) for _ in range(3)) for y in range(side))
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b""))


def textured(file, image, **more):
    texture = file.add("textures", {"source": image})
    return {"pbrMetallicRoughness": {"baseColorTexture": {"index": texture, **more}}}


def quad(file, material):
    uv = file.floats([0.0, 0, 1, 0, 0, 1], "VEC2")
    return file.add("meshes", {"primitives": [file.primitive(*TRIANGLE, file.add("materials", material), TEXCOORD_0=uv)]})


@scene(5_000, "textures of one image")
def textures(file, n):
    image = file.add("images", {"bufferView": file.view(png(64)), "mimeType": "image/png"})
    for p in grid(n):
        file.place(mesh=quad(file, textured(file, image)), translation=p)


@scene(1_000, "images")
def images(file, n):
    data = png(16)
    for p in grid(n):
        image = file.add("images", {"bufferView": file.view(data), "mimeType": "image/png"})
        file.place(mesh=quad(file, textured(file, image)), translation=p)


@scene(500, "thousands of pixels of an image")
def pixels(file, n):
    image = file.add("images", {"bufferView": file.view(png(round((1000 * n) ** 0.5))), "mimeType": "image/png"})
    file.place(mesh=quad(file, textured(file, image)))


@scene(5_000, "materials that nothing uses")
def unused_materials(file, n):
    room(file)
    image = file.add("images", {"bufferView": file.view(png(16)), "mimeType": "image/png"})
    for _ in range(n):
        file.add("materials", textured(file, image))


@scene(2_000, "variants of every material")
def variants(file, n):
    file.json["extensions"] = {"KHR_materials_variants": {"variants": [{"name": f"v{i}"} for i in range(n)]}}
    file.place(mesh=file.mesh(*CUBE, PLAIN))
    mapping = [{"material": 0, "variants": [i]} for i in range(n)]
    file.json["meshes"][0]["primitives"][0]["extensions"] = {"KHR_materials_variants": {"mappings": mapping}}


@scene(5_000, "channels of an animation")
def channels(file, n):
    mesh = file.mesh(*CUBE, PLAIN)
    times, values = file.floats([0.0, 1.0], "SCALAR"), file.floats([0.0, 0, 0, 1, 1, 1])
    nodes = [file.place(mesh=mesh, translation=p) for p in grid(n)]
    sampler = [{"input": times, "output": values} for _ in nodes]
    file.json["animations"] = [{"samplers": sampler, "channels": [{"sampler": i, "target": {"node": node, "path": "scale"}} for i, node in enumerate(nodes)]}]


@scene(100_000, "keys of a channel")
def keys(file, n):
    times, values = file.floats([float(i) for i in range(n)], "SCALAR"), file.floats([0.0] * (3 * n))
    node = file.place(mesh=file.mesh(*CUBE, PLAIN))
    file.json["animations"] = [{"samplers": [{"input": times, "output": values}], "channels": [{"sampler": 0, "target": {"node": node, "path": "translation"}}]}]


@scene(5_000, "joints of a skin")
def joints(file, n):
    zero, weight = file.add("accessors", {"bufferView": file.view(bytes(32)), "componentType": 5121, "count": 8, "type": "VEC4"}), file.floats([1.0, 0, 0, 0] * 8, "VEC4")
    mesh = file.mesh(*CUBE, PLAIN)
    file.json["meshes"][mesh]["primitives"][0]["attributes"].update(JOINTS_0=zero, WEIGHTS_0=weight)
    bones = [file.place(translation=p) for p in grid(n)]
    file.json["skins"] = [{"joints": bones}]
    file.place(mesh=mesh, skin=0)


@scene(2_000, "targets of a morph")
def morphs(file, n):
    mesh = file.mesh(*CUBE, PLAIN)
    deltas = file.floats([0.001] * 24)
    file.json["meshes"][mesh]["primitives"][0]["targets"] = [{"POSITION": deltas}] * n
    file.json["meshes"][mesh]["weights"] = [0.1] * n
    file.place(mesh=mesh)


@scene(2_000, "thousands of characters of a name, and of extras")
def text(file, n):
    file.place(mesh=file.mesh(*CUBE, PLAIN), name="x" * (1000 * n), extras={str(i): [i] for i in range(20 * n)})


if __name__ == "__main__":
    name, count, path = sys.argv[1:]
    empty(path) if name == "empty" else SCENES[name][2](path, int(count))
