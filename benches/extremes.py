#!/usr/bin/env python3
"""Growth of loading, building and rendering: extreme scenes of size n and 4 n, and how many times as long the larger one takes.

usage: extremes.py [--nephrite FILE] [--only NAME,NAME] [--limit 8] [-k 3] [--scale 1] [--timeout 300]

Writes each scene of extreme_scenes.py twice, renders 16 x 16 pixels with one sample on one thread, and prints a table: seconds
of loading and building (least of -k runs, less those of an empty scene), of rendering, ratios, and most memory. Exit code 1
where loading and building take more than --limit times as long, or a render fails. Needs nothing but Python.

Rendering is not held against the limit. Where light goes through n surfaces, a path has n times as much to do, and where their
boxes all lie in each other, each step looks at all of them.
"""
import argparse, json, os, pathlib, subprocess, sys, tempfile

from extreme_scenes import SCENES

HERE = pathlib.Path(__file__).parent
NEPHRITE = HERE.parent / "target/release/nephrite"
# Times below this are those of starting a program.
LEAST = 0.01


def render(nephrite, scene, timeout):
    """Seconds of loading and building and of rendering, MiB at most, and what was said if it failed."""
    out, stats, err = (scene.with_suffix(s) for s in (".png", ".json", ".err"))
    stats.unlink(missing_ok=True)
    with open(err, "wb") as said:
        child = subprocess.Popen(["timeout", str(timeout), nephrite, "render", scene, "-o", out, "--size", "16x16", "--spp", "1",
                                  "--threads", "1", "--quiet", "--stats", stats], stderr=said)
        _, status, usage = os.wait4(child.pid, 0)
    failure = None if status == 0 else err.read_text()[-200:] or f"status {status}"
    times = json.loads(stats.read_text()) if stats.exists() else {}
    before = times.get("load_seconds", timeout) + times.get("build_seconds", 0)
    return before, times.get("render_seconds", timeout), usage.ru_maxrss / 1024, failure


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--nephrite", default=NEPHRITE)
    p.add_argument("--only", default="")
    p.add_argument("--limit", type=float, default=8.0)
    p.add_argument("-k", type=int, default=3)
    p.add_argument("--scale", type=float, default=1.0, help="sizes relative to those of the table")
    p.add_argument("--timeout", type=int, default=300)
    a = p.parse_args()
    names = [n for n in a.only.split(",") if n] or list(SCENES)
    failed = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)

        def measure(name, n):
            scene = folder / f"{name}.glb"
            # In a process of its own: a child begins with the memory of its parent.
            subprocess.run([sys.executable, HERE / "extreme_scenes.py", name, str(n), scene], check=True)
            runs = [render(a.nephrite, scene, a.timeout) for _ in range(a.k)]
            for file in folder.iterdir():
                file.unlink()
            failure = next((r[3] for r in runs if r[3]), None)
            return min(r[0] for r in runs), min(r[1] for r in runs), max(r[2] for r in runs), failure

        base = measure("empty", 1)
        print("| scene | n | load and build, s | at 4 n | times | render, s | at 4 n | times | MiB | at 4 n |\n" + "| --- " * 10 + "|")
        for name in names:
            n, what, _ = SCENES[name]
            n = max(1, round(n * a.scale))
            small, large = (measure(name, m) for m in (n, 4 * n))
            cells, ratios = [what, str(n)], []
            for i in (0, 1):
                seconds = [max(r[i] - base[i], 0.0) for r in (small, large)]
                ratios.append(max(seconds[1], LEAST) / max(seconds[0], LEAST))
                cells += [f"{seconds[0]:.3f}", f"{seconds[1]:.3f}", f"{ratios[-1]:.1f}"]
            print("| " + " | ".join([*cells, f"{small[2]:.0f}", f"{large[2]:.0f}"]) + " |", flush=True)
            failure = small[3] or large[3]
            if failure or ratios[0] > a.limit:
                failed.append(name)
                print(f"{name}: {failure or f'{ratios[0]:.1f} times'}", file=sys.stderr)
    if failed:
        sys.exit(f"too slow or failed: {', '.join(failed)}")


if __name__ == "__main__":
    main()
