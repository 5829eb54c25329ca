#!/usr/bin/env python3
"""Makes the corpus: small files that have everything.

usage: fuzz/corpus.py (needs Pillow, OpenEXR and NumPy)

The samples of this repository keep their documents, but twelve elements of each accessor and a pixel or four of each
image, so that a mutation meets what matters and a load takes a fraction of a millisecond. `everything.gltf` is written by
hand; the materials are those of the dictionary. Payloads are streams from the tests and images that Pillow writes, environments those that OpenEXR writes and Radiance files by hand.
"""
import io, json, pathlib, re, struct
import Imath, numpy, OpenEXR
from PIL import Image

HERE = pathlib.Path(__file__).parent
ROOT = HERE.parent
ELEMENTS = 12
SIZES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


def chunks(data):
    size = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20 : 20 + size])
    return document, data[20 + size + 8 :]


def glb(document, binary):
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    body = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


def tiny_image(data, kind):
    image = Image.open(io.BytesIO(data)).resize((2, 2))
    out = io.BytesIO()
    image.save(out, {"image/jpeg": "JPEG", "image/webp": "WEBP"}.get(kind, "PNG"))
    return out.getvalue()


def reduced(path):
    document, binary = chunks(path.read_bytes())
    views, accessors = document["bufferViews"], document.get("accessors", [])
    out, new_views = b"", []

    def view(data):
        nonlocal out
        out += b"\0" * (-len(out) % 4)
        new_views.append({"buffer": 0, "byteOffset": len(out), "byteLength": len(data)})
        out += data
        return len(new_views) - 1

    indices = {p["indices"] for m in document["meshes"] for p in m["primitives"] if "indices" in p}
    for i, accessor in enumerate(accessors):
        old = views[accessor["bufferView"]]
        width = SIZES[accessor["componentType"]] * WIDTHS[accessor["type"]]
        start = old.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = old.get("byteStride", width)
        count = min(accessor["count"], ELEMENTS)
        data = b"".join(binary[start + k * stride : start + k * stride + width] for k in range(count))
        if i in indices:
            letter = {1: "B", 2: "H", 4: "I"}[width]
            data = struct.pack(f"<{count}{letter}", *(v % ELEMENTS for v in struct.unpack(f"<{count}{letter}", data)))
        accessor["count"] = count
        accessor["bufferView"] = view(data)
        accessor.pop("byteOffset", None)
    for image in document.get("images", []):
        old = views[image["bufferView"]]
        start = old.get("byteOffset", 0)
        image["bufferView"] = view(tiny_image(binary[start : start + old["byteLength"]], image.get("mimeType")))
    document["bufferViews"] = new_views
    document["buffers"] = [{"byteLength": len(out)}]
    return glb(document, out)


def encoded(kind):
    out = io.BytesIO()
    image = Image.new("RGBA", (5, 3), (200, 100, 50, 128))
    image.putpixel((1, 1), (0, 255, 0, 255))
    (image.convert("RGB") if kind == "JPEG" else image).save(out, kind, lossless=False)
    return out.getvalue()


def ktx(vk_format, width, height, scheme, level, model=0):
    """A KTX 2.0 file of one level, whose data format descriptor says nothing but the color model."""
    descriptor = struct.pack("<IIHHBBBBBBBB", 44, 0, 2, 40, model, 1, 2, 0, 3, 3, 0, 0).ljust(44, b"\0")
    header = b"\xABKTX 20\xBB\r\n\x1A\n" + struct.pack("<13I", vk_format, 1, width, height, 0, 0, 1, 1, scheme, 104, 44, 0, 0)
    return header + bytes(16) + struct.pack("<3Q", 148, len(level), len(level)) + descriptor + level


def radiance(folder):
    """Radiance files of 16 × 8 pixels: flat, the old and the new run lengths, other orders, XYZ."""
    rows = [[(128 + x, 64 + 8 * y, 32, 129) for x in range(16)] for y in range(8)]
    flat = b"".join(bytes(p) for row in rows for p in row)
    new = b""
    for row in rows:
        new += bytes([2, 2, 0, 16, 16]) + bytes(p[0] for p in row)
        new += b"".join(bytes([144, row[0][c]]) for c in (1, 2, 3))
    old = b"".join(bytes([*row[0], 1, 1, 1, 14, *row[15]]) for row in rows)
    rgbe, resolution = "FORMAT=32-bit_rle_rgbe", "-Y 8 +X 16"
    for name, lines, size, pixels in (
        ("flat.hdr", rgbe, resolution, flat),
        ("new.hdr", rgbe + "\nEXPOSURE=2\nCOLORCORR=1 2 1", resolution, new),
        ("old.hdr", "SOFTWARE=x", resolution, old),
        ("xyz.hdr", "FORMAT=32-bit_rle_xyze", "+Y 8 -X 16", new),
        ("columns.hdr", rgbe, "-X 8 +Y 16", new),
    ):
        (folder / name).write_bytes(f"#?RADIANCE\n{lines}\n\n{size}\n".encode() + pixels)


def openexr(folder):
    """OpenEXR files of 24 × 10 pixels: every compression, tiles, layers, luminance and chroma, a window within another."""
    noise = numpy.random.default_rng(1)
    half = lambda *shape: noise.random(shape, dtype=numpy.float32).astype(numpy.float16)
    c = OpenEXR
    kinds = {
        "none": c.NO_COMPRESSION, "rle": c.RLE_COMPRESSION, "zips": c.ZIPS_COMPRESSION, "zip": c.ZIP_COMPRESSION,
        "piz": c.PIZ_COMPRESSION, "pxr24": c.PXR24_COMPRESSION, "b44": c.B44_COMPRESSION, "b44a": c.B44A_COMPRESSION,
        "dwaa": c.DWAA_COMPRESSION, "dwab": c.DWAB_COMPRESSION,
    }

    def write(name, channels, **header):
        header = {"compression": c.ZIP_COMPRESSION, "type": c.scanlineimage} | header
        c.File(header, channels).write(str(folder / f"{name}.exr"))

    smooth = numpy.add.outer(numpy.arange(10), numpy.arange(24)).astype(numpy.float16) / 8
    for name, kind in kinds.items():
        write(name, {"R": smooth, "G": smooth * 2, "B": smooth / 2}, compression=kind)
    write("float", {"R": smooth.astype(numpy.float32), "G": half(10, 24).astype(numpy.float32), "B": half(10, 24)})
    write("tiles", {n: half(10, 24) for n in "RGB"}, type=c.tiledimage, tiles=c.TileDescription())
    write("layers", {f"ViewLayer.Combined.{n}": half(10, 24) for n in "RGBA"} | {"ViewLayer.Depth.Z": half(10, 24)})
    windows = {"dataWindow": ((4, 2), (27, 11)), "displayWindow": ((0, 0), (31, 15))}
    windows = {k: tuple(numpy.array(v, numpy.int32) for v in w) for k, w in windows.items()}
    write("windows", {n: half(10, 24) for n in "rgb"}, **windows)
    for name, kind in (("none", 0), ("zip", 3), ("piz", 4), ("pxr24", 5), ("dwaa", 8)):
        header = OpenEXR.Header(24, 10)
        header["compression"] = Imath.Compression(kind)
        channel = lambda step: Imath.Channel(Imath.PixelType(Imath.PixelType.HALF), step, step)
        header["channels"] = {"Y": channel(1), "RY": channel(2), "BY": channel(2)}
        file = OpenEXR.OutputFile(str(folder / f"chroma-{name}.exr"), header)
        few = smooth[::2, ::2]
        file.writePixels({"Y": smooth.tobytes(), "RY": (few / 8).tobytes(), "BY": (few / -16).tobytes()}, 10)
        file.close()
    parts = [c.Part({"type": c.scanlineimage, "compression": c.ZIP_COMPRESSION}, {"Z": half(10, 24)}, "depth"),
             c.Part({"type": c.scanlineimage, "compression": c.ZIP_COMPRESSION}, {n: half(10, 24) for n in "RGB"}, "rgba")]
    c.File(parts).write(str(folder / "parts.exr"))


def main():
    environments = HERE / "corpus" / "environments"
    environments.mkdir(parents=True, exist_ok=True)
    radiance(environments)
    openexr(environments)
    for folder in ("loader", "extensions", "payloads"):
        (HERE / "corpus" / folder).mkdir(parents=True, exist_ok=True)
    for path in sorted(ROOT.glob("samples/*/*.glb")):
        (HERE / "corpus" / "loader" / path.name).write_bytes(reduced(path))
    payloads = HERE / "corpus" / "payloads"
    for kind in ("PNG", "JPEG", "WEBP"):
        (payloads / kind.lower()).write_bytes(b"\x02" + encoded(kind))
    # R8G8B8A8, R16G16B16A16 float, BC1, BC7, ETC2 and ASTC 4 × 4.
    for vk_format, size in ((37, 16), (97, 32), (133, 8), (145, 16), (147, 8), (157, 16)):
        level = bytes((7 * i + 3) & 0xFF for i in range(size))
        (payloads / f"ktx-{vk_format}").write_bytes(b"\x02" + ktx(vk_format, 2, 2, 0, level))
    (payloads / "ktx-uastc").write_bytes(b"\x02" + ktx(0, 4, 4, 0, bytes(range(16)), 166))
    frame = b"\x28\xB5\x2F\xFD\x20\x10\x81\0\0" + bytes(range(16))
    (payloads / "ktx-zstandard").write_bytes(b"\x02" + ktx(37, 2, 2, 2, frame))
    tests = (ROOT / "src/extension/compressed_tests.rs").read_text()
    streams = tests[tests.index("const DRACO") : tests.index("];\n\nfn draco")]
    for i, part in enumerate(streams.split("&[\n")[1:]):
        numbers = [int(n) for n in part.split("]")[0].replace("\n", " ").split(",") if n.strip()]
        (payloads / f"draco-{i}").write_bytes(b"\0" + bytes(numbers))
    dictionary = (HERE / "src/dictionary.rs").read_text()
    for name, own in re.findall(r'"(\w+_materials_\w+)",\s*(?:r#)?"({.*?})"#?', dictionary):
        extensions = {name: json.loads(own)}
        if name != "KHR_materials_unlit":
            extensions.setdefault("KHR_materials_transmission", {"transmissionFactor": 1})
        surface = {"baseColorFactor": [0.9, 0.8, 0.7, 1], "metallicFactor": 0, "baseColorTexture": {"index": 0}}
        material = {"pbrMetallicRoughness": surface, "extensions": extensions}
        (HERE / "corpus/extensions" / f"{name}.json").write_text(json.dumps(material, separators=(",", ":")))
    meshopt = {
        # mode and filter, stride, count; then the stream.
        "attributes": ([0, 4, 3, 0], [0xA0] + [0] * 4 + [0] * 32),
        "octahedral": ([4, 4, 3, 0], [0xA1] + [0] * 4 + [0] * 32),
        "quaternion": ([8, 8, 3, 0], [0xA0] + [0] * 8 + [0] * 32),
        "exponential": ([12, 12, 4, 0], [0xA0] + [0] * 12 + [0] * 32),
        "triangles": ([1, 2, 12, 0], [0xE1, 0xF0, 0x10, 0xFE, 0x1F] + [0] * 16),
        "sequence": ([2, 2, 3, 0], [0xD1, 0, 4, 4, 0, 0, 0, 0]),
    }
    for name, (parameters, stream) in meshopt.items():
        (payloads / f"meshopt-{name}").write_bytes(bytes([1, *parameters, *stream]))


main()
