#!/usr/bin/python3
"""How fast is gvx's CPU renderer beside VTK's and ray casters over NanoVDB and Open VKL, on the same work?

    bench/peers/run [--frames N] [--threads N] [--only TEXT] [--narrow] [--far TIMES]

A column is a volume, a function, and shading off or on. In each, after a frame to warm up, the systems
render by turns, so that all see the same machine. Prints medians and ratios, writes them to
out/bench/peers.{md,json} and each system's picture to out/bench/peers. Fails where a peer's unlit picture is
less than 35 dB like gvx's: then the work was not the same.
With --far the eye is that many times as far away and gvx shows what it would show anyone: levels of detail,
pre-integrated. That is other work, whose pictures peers' need not be like: it goes to peers-far.{md,json}.
GVX_PEERS_BUILD names the folder of the build.
"""

import argparse
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys

import numpy as np
from PIL import Image

import volumes
from volumes import peer

here = pathlib.Path(__file__).resolve().parent
root = here.parents[1]
build = pathlib.Path(os.environ.get("GVX_PEERS_BUILD", root / "build/release"))
folder = root / "out/bench/peers"

PIXELS = 1024
LEAST_PSNR = 35  # dB, of unlit pictures
SHORT = 8  # voxels of a ray
# Opacities of a voxel's length. "surface": a steep step to opaque, transparent below. "translucent": faint
# over most values. Walls of the foam are so steep that a sample a voxel meets any of their values: of a colour
# that varies much, systems that sample in other places would show other pictures of the same work.
FUNCTIONS = {
    ("foam", "surface"): {
        "colors": [[60, 0.8, 0.6, 0.4], [250, 0.9, 0.75, 0.55]], "opacities": [[60, 0], [100, 0.95]]},
    ("foam", "translucent"): {
        "colors": [[0, 0.2, 0.35, 0.8], [250, 1, 0.8, 0.4]], "opacities": [[5, 0], [250, 0.02]]},
    ("head", "surface"): {
        "colors": [[40, 0.8, 0.5, 0.4], [150, 1, 0.95, 0.85]], "opacities": [[44, 0], [64, 0.95]]},
    ("head", "translucent"): {
        "colors": [[30, 0.8, 0.4, 0.25], [120, 1, 0.95, 0.8]], "opacities": [[30, 0], [255, 0.025]]},
}
# The light is the camera's.
LIGHTING = {"ambient": 0.2, "diffuse": 0.8, "specular": 0.3, "shininess": 10,
            "lights": [{"kind": "camera", "place": [0, 0, 1], "color": [1, 1, 1]}]}
SYSTEMS = {"gvx": "gvx", "vtk": "VTK", "nanovdb": "NanoVDB", "vkl": "Open VKL"}
# Ray casters over libraries that may not be there, and what they need.
CASTERS = {"nanovdb": "libnanovdb-dev", "vkl": "Open VKL 2"}


def camera(far):
    """Half from the side and from above, the whole cube in the picture with a fiftieth of it to spare; then so
    many times as far away."""
    toward = np.array([0.45, 1, 0.4]) / np.linalg.norm([0.45, 1, 0.4])
    target = np.full(3, (volumes.SIZE - 1) / 2)
    view = {"eye": (target + 3.2 * volumes.SIZE * toward).tolist(), "target": target.tolist(),
            "up": [0, 0, 1]}
    right, up, ahead = peer.camera_axes(view)
    corners = np.array([[i >> axis & 1 for axis in range(3)] for i in range(8)]) * (volumes.SIZE - 1)
    corners = corners - view["eye"]
    widest = max(np.abs(corners @ axis / (corners @ ahead)).max() for axis in (right, up))
    eye = target + far * (np.array(view["eye"]) - target)
    return {**view, "eye": eye.tolist(), "fov": 2 * math.degrees(math.atan(widest / 0.98))}


class System:
    """A process that renders when it is told to; frames.h says how."""

    def __init__(self, name, command):
        self.name = name
        self.process = subprocess.Popen([str(c) for c in command], text=True, stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE)

    def ask(self, line):
        try:
            self.process.stdin.write(line + "\n")
            self.process.stdin.flush()
        except BrokenPipeError:
            pass
        answer = self.process.stdout.readline().strip()
        if not answer:
            sys.exit(f"{SYSTEMS[self.name]}: ended at \"{line}\" with status {self.process.wait()}")
        return answer

    def picture(self, png):
        """The last frame, also saved."""
        raw = png.with_suffix(".rgb")
        self.ask(f"save {raw}")
        pixels = np.fromfile(raw, np.uint8).reshape(PIXELS, PIXELS, 3)
        raw.unlink()
        Image.fromarray(pixels).save(png)
        return pixels

    def end(self):
        self.process.stdin.close()
        self.process.wait()


def start(volume, threads, how):
    """The systems that were built, with this volume in each; `how` gvx is to show it, in its words."""
    raw = volumes.make(volume, folder, root, build / "bench/gvx_make_foam")
    store = folder / f"{volume}.gvx"
    subprocess.run([build / "apps/gvx/gvx", "build", raw.with_suffix(".nhdr"), "-o", store, "--force"],
                   stdout=subprocess.DEVNULL, check=True)
    gvx = [build / "bench/peers/gvx_peers_gvx", store, threads]
    systems = [System("gvx", gvx + how),
               System("vtk", ["/usr/bin/python3", here / "vtk_frames.py", raw, volumes.SIZE, threads])]
    for name, needed in CASTERS.items():
        program = build / f"bench/peers/gvx_peers_{name}"
        if program.exists():
            systems.append(System(name, [program, raw, volumes.SIZE, threads]))
        else:
            print(f"{SYSTEMS[name]}: left out, {needed} was not found when this was built", file=sys.stderr)
    return systems


def long_rays(view):
    """Of which pixels are the rays SHORT voxels or more in the volume? Shorter ones, along its outline, may
    hold an opaque sample or none: that is chance."""
    right, up, ahead = peer.camera_axes(view)
    across = (np.arange(PIXELS) + 0.5 - PIXELS / 2) * 2 * math.tan(math.radians(view["fov"] / 2)) / PIXELS
    ray = ahead + across[None, :, None] * right - across[:, None, None] * up
    ray /= np.linalg.norm(ray, axis=2, keepdims=True)
    with np.errstate(divide="ignore"):
        faces = np.stack([(face - np.array(view["eye"])) / ray for face in (0, volumes.SIZE - 1)])
    return faces.max(0).min(2) - faces.min(0).max(2) >= SHORT


def psnr(a, b, pixels):
    square = np.mean((a[pixels].astype(float) - b[pixels]) ** 2) / 255**2
    return round(10 * math.log10(1 / square), 1) if square > 0 else math.inf


def measure(column, systems, frames, far):
    """A row of the table."""
    volume, function, lit = column
    name = f"{volume}-{function}-{'lit' if lit else 'unlit'}" + ("-far" if far != 1 else "")
    view = folder / f"{name}.json"
    view.write_text(json.dumps({"size": [PIXELS, PIXELS], "camera": camera(far),
                                "functions": [FUNCTIONS[volume, function]],
                                "lighting": {"enabled": lit, **LIGHTING}}, indent=1) + "\n")
    for system in systems:
        system.ask(f"view {view}")
    times = {system.name: [] for system in systems}
    for _ in range(frames):
        for system in systems:
            times[system.name].append(float(system.ask("frame")))
    pictures = {system.name: system.picture(folder / f"{name}-{system.name}.png") for system in systems}
    seen = long_rays(camera(far))
    return {"column": name, "volume": volume, "function": function, "lit": lit,
            "ms": {s: {"median": round(statistics.median(t), 1), "least": round(min(t), 1),
                       "most": round(max(t), 1), "frames": [round(ms, 2) for ms in t]}
                   for s, t in times.items()},
            "ratio": {s: round(statistics.median(t) / statistics.median(times["gvx"]), 2)
                      for s, t in times.items() if s != "gvx"},
            "psnr_db": {s: psnr(pictures["gvx"], p, seen) for s, p in pictures.items() if s != "gvx"}}


def geometric_means(rows):
    """Of each peer's ratios: all, unlit and lit, and the smallest."""
    means = {}
    for peer_name in rows[0]["ratio"]:
        ratios = {what: [r["ratio"][peer_name] for r in rows if lit is None or r["lit"] == lit]
                  for what, lit in (("all", None), ("unlit", False), ("lit", True))}
        means[peer_name] = {what: round(statistics.geometric_mean(v), 2) for what, v in ratios.items() if v}
        means[peer_name]["least"] = min(ratios["all"])
    return means


def table(rows, means):
    peers = list(means)
    lines = ["| column | " + " | ".join(f"{SYSTEMS[s]} ms" for s in ["gvx", *peers]) + " | " +
             " | ".join(f"{SYSTEMS[s]} / gvx" for s in peers) + " | " +
             " | ".join(f"{SYSTEMS[s]} to gvx, dB" for s in peers) + " |",
             "|---" * (2 + 3 * len(peers)) + "|"]
    for row in rows:
        cells = [f"{row['volume']}, {row['function']}{', lit' if row['lit'] else ''}"]
        cells += [f"{m['median']:.0f} ({m['least']:.0f} to {m['most']:.0f})" for m in row["ms"].values()]
        cells += [f"{row['ratio'][s]:.2f}" for s in peers] + [f"{row['psnr_db'][s]}" for s in peers]
        lines.append("| " + " | ".join(cells) + " |")
    for what, title in (("unlit", "geometric mean, unlit"), ("lit", "geometric mean, lit"),
                        ("all", "geometric mean"), ("least", "smallest")):
        if all(what in means[s] for s in peers):
            lines.append(f"| {title} |" + " |" * (1 + len(peers)) +
                         "".join(f" {means[s][what]:.2f} |" for s in peers) + " |" * len(peers))
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=5, help="measured in each column")
    parser.add_argument("--threads", type=int, default=2, help="of each system")
    parser.add_argument("--only", default="", help="columns with this in their name, as head or unlit")
    parser.add_argument("--narrow", action="store_true", help="gvx without vectors of AVX-512")
    parser.add_argument("--far", type=float, default=1, metavar="TIMES",
                        help="the eye so many times as far away, and levels of detail in gvx")
    options = parser.parse_args()
    if options.frames < 1 or options.threads < 1:
        parser.error("--frames and --threads must be 1 or more")
    if not 1 <= options.far <= 1000:
        parser.error("--far must be from 1 to 1000")
    is_far = options.far != 1
    how = ["narrow"] * options.narrow + ["levels"] * is_far
    folder.mkdir(parents=True, exist_ok=True)

    columns = [(*key, lit) for key in FUNCTIONS for lit in (False, True)]
    columns = [c for c in columns if options.only in f"{c[0]}-{c[1]}-{'lit' if c[2] else 'unlit'}"]
    if not columns:
        parser.error(f"--only {options.only}: no column has that in its name")
    rows = []
    for volume in dict.fromkeys(c[0] for c in columns):
        systems = start(volume, options.threads, how)
        for column in (c for c in columns if c[0] == volume):
            rows.append(measure(column, systems, options.frames, options.far))
            print(rows[-1], file=sys.stderr, flush=True)
        for system in systems:
            system.end()

    means = geometric_means(rows)
    lines = table(rows, means)
    print("\n".join(lines))
    result = {"size": volumes.SIZE, "pixels": PIXELS, "threads": options.threads, "frames": options.frames,
              "narrow": options.narrow, "far": options.far,
              "columns": rows, "geometric_mean": means}
    out = root / ("out/bench/peers-far" if is_far else "out/bench/peers")
    out.with_suffix(".md").write_text("\n".join(lines) + "\n")
    out.with_suffix(".json").write_text(json.dumps(result, indent=1) + "\n")
    unlike = [f"{r['column']}: {SYSTEMS[s]}'s picture is {db} dB from gvx's" for r in rows if not r["lit"]
              for s, db in r["psnr_db"].items() if db < LEAST_PSNR]
    if unlike and not is_far:
        sys.exit("\n".join(unlike) + f"\nless than {LEAST_PSNR}: the work was not the same")


if __name__ == "__main__":
    main()
