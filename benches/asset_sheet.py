#!/usr/bin/env python3
"""Renders every glTF file below a folder to one contact sheet.

    python3 benches/asset_sheet.py ASSETS_DIR OUT.png [--size 128] [--spp 16] [--match TEXT] [--nephrite PROGRAM]

Files are rendered one after another, each with a time limit, and labelled with their names. What fails is a grey square
on the sheet and a line of the report on the standard output; the exit status is 1 if anything failed. Needs Pillow.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

LABEL = 24


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("assets", type=Path, help="folder (searched to the bottom) or list of files, one a line")
    parser.add_argument("output", type=Path, help="the sheet, a .png")
    parser.add_argument("--size", type=int, default=128, help="pixels of a picture's side [128]")
    parser.add_argument("--spp", type=int, default=16, help="samples a pixel [16]")
    parser.add_argument("--columns", type=int, default=0, help="pictures in a row [as many as make it about square]")
    parser.add_argument("--match", default="", help="only files whose path contains this text")
    parser.add_argument("--timeout", type=float, default=60, help="seconds for a file [60]")
    parser.add_argument("--nephrite", default="target/release/nephrite", help="the program")
    parser.add_argument("--option", action="append", default=[], help="one more option of render, such as --option=--env=none")
    return parser.parse_args()


def find(folder, text):
    if folder.is_file():
        files = [Path(line.strip()) for line in folder.read_text().splitlines() if line.strip()]
    else:
        files = sorted(p for p in folder.rglob("*") if p.suffix.lower() in (".gltf", ".glb"))
    return [f for f in files if text in str(f)]


def render(options, file, picture):
    """A picture, or what went wrong."""
    size = f"{options.size}x{options.size}"
    command = [options.nephrite, "render", str(file), "-o", str(picture), "--size", size, "--spp", str(options.spp), "-q"]
    try:
        done = subprocess.run(command + options.option, capture_output=True, text=True, timeout=options.timeout)
    except subprocess.TimeoutExpired:
        return None, f"took longer than {options.timeout:g} s"
    if done.returncode != 0 or not picture.exists():
        lines = done.stderr.strip().splitlines()
        return None, lines[-1] if lines else f"exit status {done.returncode}"
    with Image.open(picture) as image:
        return image.convert("RGB"), None


def main():
    options = arguments()
    files = find(options.assets, options.match)
    if not files:
        sys.exit(f"no .gltf or .glb below {options.assets}")
    columns = options.columns or max(1, round(len(files) ** 0.5))
    rows = -(-len(files) // columns)
    cell = options.size + LABEL
    sheet = Image.new("RGB", (columns * options.size, rows * cell), "white")
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default()
    failures = 0
    with tempfile.TemporaryDirectory() as folder:
        for i, file in enumerate(files):
            picture = Path(folder) / "picture.png"
            picture.unlink(missing_ok=True)
            image, problem = render(options, file, picture)
            if problem:
                failures += 1
                print(f"{file}: {problem}", flush=True)
                image = Image.new("RGB", (options.size, options.size), "grey")
            x, y = i % columns * options.size, i // columns * cell
            sheet.paste(image, (x, y))
            letters = max(1, options.size // 6)
            name = file.stem
            draw.text((x + 2, y + options.size), name[:letters], "black", font)
            draw.text((x + 2, y + options.size + LABEL // 2), name[letters : 2 * letters], "black", font)
    sheet.save(options.output)
    print(f"{len(files) - failures} of {len(files)} files are on {options.output}")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
