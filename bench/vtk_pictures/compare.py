#!/usr/bin/python3
"""gvx's pictures beside those of VTK's CPU ray caster: same volume, camera, function, light and step.

    bench/vtk_pictures/run [NAME...]         scenes/peer-NAME.json; all without names

Prints a table, writes it to out/bench/vtk/compare.{md,json} and, of each scene, gvx's picture, VTK's, their difference
(four times as strong), and the three in a row. Needs python3-vtk9, python3-numpy, python3-pil of the system's Python.
GVX_PROGRAM names the program, GVX_TEST_DATA the folder of volumes.
"""

import json
import subprocess
import sys
import time

import numpy as np

import peer
import pictures

names = sys.argv[1:] or [f"{v}-{k}" for v in ("head", "bonsai", "engine") for k in ("unlit", "shaded", "maximum")]
names = names if sys.argv[1:] else names + ["engine-side", "head-haze"]
pictures.out.mkdir(parents=True, exist_ok=True)

if not (pictures.root / "out/head.nhdr").exists():
    subprocess.run([pictures.root / "tools/fetch_head", pictures.root / "out"], check=False)
rows, volumes = [], {}
for name in names:
    volume = name.split("-")[0]
    source = pictures.source(volume)
    if not source.exists():
        print(f"{name}: left out, {source} is not there", file=sys.stderr)
        continue
    if volume not in volumes:
        pictures.build(source, f"{volume}.gvx")
        volumes = {volume: peer.read_volume(source)}
    at = {}
    for samples in (2, 8):
        tag = f"{name}-{samples}"
        ours, scene = pictures.render(pictures.scenes / f"peer-{name}.json", f"{tag}-gvx", "--samples", str(samples))
        start = time.monotonic()
        theirs, alpha = peer.render(scene, *volumes[volume])
        seconds = time.monotonic() - start
        seen = (alpha > 0) | (np.abs(ours - scene["background"]).max(2) > 1 / 255)
        row = {"scene": name, "samples": samples, "seen": round(float(seen.mean()), 2),
               **pictures.differences(ours, theirs, seen), "offset": pictures.offset(theirs, ours),
               "brightness": [round(255 * float(p[seen].mean()), 1) for p in (ours, theirs)],
               "vtk_s": round(seconds, 1)}
        at[samples] = ours, theirs, seen
        rows.append(row)
        print(row, flush=True)
        pictures.save(pictures.out / f"{tag}-vtk.png", theirs)
        pictures.save(pictures.out / f"{tag}-difference.png", 4 * np.abs(ours - theirs))
        pictures.side_by_side(pictures.out / f"{tag}.png", [ours, theirs, 4 * np.abs(ours - theirs)],
                              ["gvx", "VTK", "difference x4"])
    # How far each is from itself at a finer step.
    for which, who in enumerate(("gvx", "vtk")):
        rows[-2][f"{who}_to_finer_db"] = pictures.differences(at[2][which], at[8][which], at[2][2])["psnr_db"]

table = ["| scene | samples a voxel | PSNR dB | mean | 95 % | brightness gvx / VTK | offset px | "
         "gvx, VTK to their finer ones, dB |",
         "|---|---|---|---|---|---|---|---|"]
for r in rows:
    table.append(f"| {r['scene']} | {r['samples']} | {r['psnr_db']} | {r['mean']} | {r['p95']} | "
                 f"{r['brightness'][0]} / {r['brightness'][1]} | {r['offset'][0]}, {r['offset'][1]} | " +
                 (f"{r['gvx_to_finer_db']}, {r['vtk_to_finer_db']} |" if "gvx_to_finer_db" in r else "|"))
print("\n".join(table))
(pictures.out / "compare.md").write_text("\n".join(table) + "\n")
(pictures.out / "compare.json").write_text(json.dumps(rows, indent=1) + "\n")
