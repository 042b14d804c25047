#!/usr/bin/env python3
"""What instances cost that are not seen: frames of 10 instances before the camera and ever more behind it.

    bench/objects/instances.py GVX FOLDER [ROUNDS]

FOLDER holds head.gvx and bunny.gvx, as docs/make_pictures leaves them in out/. Prints a table and, last, a line of
JSON. Frames are rendered by turns; figures are medians.
"""
import json
import pathlib
import random
import statistics
import subprocess
import sys
import tempfile

COUNTS = [10, 100, 1000, 10000]
# A volume, how it is shown, the middle of its box and the factor that makes it about 1 large.
VOLUMES = [({"volume": "bunny.gvx"}, (-0.1, 0.1, 0.0), 1 / 2.2),
           ({"volume": "head.gvx", "function": "ct-skin"}, (-124.9, 115.8, 78.8), 1 / 220)]


def instance(i, place):
    look, middle, factor = VOLUMES[i % len(VOLUMES)]
    matrix = [[factor if k == j else 0 for j in range(3)] + [place[k] - factor * middle[k]] for k in range(3)]
    return {**look, "transform": {"matrix": matrix}}


def scene_of(count):
    rng = random.Random(3)
    objects = [instance(i, (i % 5 - 2, 0, i // 5 - 0.5)) for i in range(10)]
    objects += [instance(i, (rng.uniform(-20, 20), rng.uniform(-60, -20), rng.uniform(-20, 20))) for i in range(10, count)]
    return {"objects": objects, "size": [1024, 512],
            "camera": {"eye": [0, -9, 1], "target": [0, 0, 0], "up": [0, 0, 1], "fov": 30}}


def main():
    gvx, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 7
    times, bricks = {count: [] for count in COUNTS}, {}
    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        scratch = pathlib.Path(scratch)
        for name in ("head.gvx", "bunny.gvx"):
            (scratch / name).symlink_to((folder / name).resolve())
        for count in COUNTS:
            (scratch / f"{count}.json").write_text(json.dumps(scene_of(count)))
        for _ in range(rounds):
            for count in COUNTS:
                subprocess.run([gvx, "render", scratch / f"{count}.json", "-o", scratch / "out.png", "--quiet",
                                "--stats", scratch / "stats.json"], check=True)
                stats = json.loads((scratch / "stats.json").read_text())
                times[count].append(stats["frame_milliseconds"])
                bricks[count] = stats["bricks_produced"]
    first = statistics.median(times[COUNTS[0]])
    print("| instances | of these seen | frame, ms | relative | bricks made |\n|---|---|---|---|---|")
    for count in COUNTS:
        median = statistics.median(times[count])
        print(f"| {count} | 10 | {median:.0f} | {median / first:.2f} | {bricks[count]} |")
    print(json.dumps({"frame_milliseconds": {str(c): statistics.median(times[c]) for c in COUNTS}, "bricks": bricks}))


if __name__ == "__main__":
    main()
