#!/usr/bin/python3
"""gvx's pictures beside the baselines of vtk-js's volume-mapper tests.

    bench/vtk_pictures/run vtkjs [NAME...]   scenes/vtkjs-NAME.json; all without names

The scene files say what the tests' sources say; volumes come from the tests' data, or are computed as there. Prints a
table, writes it to out/bench/vtk/vtkjs.{md,json} and, of each scene, the two pictures and their difference (four times as
strong) in a row. GVX_PROGRAM names the program, GVX_TEST_DATA the folder that holds `baselines`.
"""

import gzip
import json
import sys

import numpy as np

import pictures

baselines = pictures.test_data / "baselines"
cases = {  # scene: volume, and the baselines of which one must be met
    "composite": ("lidc", ["core/testComposite", "core/testComposite_2"]),
    "parallel": ("lidc", ["core/testCompositeParallelProjection"]),
    "composite16": ("headsq", ["core/testComposite16Bit", "core/testComposite16Bit_2"]),
    "maximum": ("headsq", ["core/testMaximumIntensityProjection"]),
    "minimum": ("headsq", ["core/testMinimumIntensityProjection"]),
    "mean": ("headsq", ["core/testAverageIntensityProjection"]),
    "lighting": ("headsq", ["opengl/testLighting", "opengl/testLighting_2"]),
    "large": ("large", ["opengl/testLargeScalars"]),
    "extents": ("octants", ["opengl/testUpdatedExtents"]),
}


def write_nrrd(name, voxels, directions, origin):
    """Voxels [z, y, x]; the rows of `directions` are the steps along x, y, z."""
    kind = {"u1": "uint8", "i2": "int16", "f4": "float"}[voxels.dtype.str[1:]]
    as_text = " ".join("(" + ",".join(f"{v:.9g}" for v in row) + ")" for row in directions)
    (pictures.out / f"{name}.raw").write_bytes(voxels.tobytes())
    (pictures.out / f"{name}.nhdr").write_text(
        f"NRRD0005\ntype: {kind}\ndimension: 3\nsizes: {' '.join(map(str, voxels.shape[::-1]))}\n"
        f"space: right-anterior-superior\nspace directions: {as_text}\n"
        f"space origin: ({','.join(f'{v:.9g}' for v in origin)})\nendian: little\nencoding: raw\ndata file: {name}.raw\n")


def convert(folder, name):
    """A vtk-js image: index.json, and its array as a gz file."""
    index = json.loads((folder / "index.json").read_text())
    array = index["pointData"]["arrays"][0]["data"]
    kind = {"Uint8Array": "u1", "Int16Array": "<i2"}[array["dataType"]]
    reference = array["ref"]
    data = gzip.open(folder / reference["basepath"] / (reference["id"] + ".gz")).read()
    extent = np.reshape(index["extent"], (3, 2))
    voxels = np.frombuffer(data, kind).reshape((extent[:, 1] - extent[:, 0] + 1)[::-1])
    directions = np.reshape(index.get("direction", np.eye(3).ravel()), (3, 3)) * np.reshape(index["spacing"], (3, 1))
    write_nrrd(name, voxels, directions, index["origin"])


def large():
    """testLargeScalarVolume: waves in a ball, of values to 2.4 million."""
    z, y, x = np.indices((100, 100, 100))
    inside = (x - 50) ** 2 + (y - 50) ** 2 + (z - 50) ** 2 < 45**2
    waves = 400000 * (3 + np.cos(x / 20) + np.cos(y / 10) + np.cos(z / 5))
    write_nrrd("large", np.where(inside, waves, 0).astype("<f4"), np.eye(3), [0, 0, 0])


def octants():
    """testUpdatedExtents: a ball of ones, of which only two octants reach the screen."""
    z, y, x = np.indices((100, 100, 100))
    ball = (x - 50) ** 2 + (y - 50) ** 2 + (z - 50) ** 2 < 49**2
    low, high = np.maximum(np.maximum(x, y), z) <= 49, np.minimum(np.minimum(x, y), z) >= 49
    write_nrrd("octants", (ball & (low | high)).astype("<f4"), np.eye(3), [0, 0, 0])


makers = {"lidc": lambda: convert(baselines / "vtkjs_data/volume/LIDC2.vti", "lidc"),
          "headsq": lambda: convert(baselines / "vtkjs_data/volume/headsq.vti", "headsq"),
          "large": large, "octants": octants}

if not baselines.exists():
    sys.exit(f"{baselines}: not there; set GVX_TEST_DATA")
pictures.out.mkdir(parents=True, exist_ok=True)
rows, made = [], set()
for name in sys.argv[1:] or cases:
    volume, references = cases[name]
    if volume not in made:
        makers[volume]()
        pictures.build(pictures.out / f"{volume}.nhdr", f"{volume}.gvx")
        made.add(volume)
    ours, scene = pictures.render(pictures.scenes / f"vtkjs-{name}.json", f"vtkjs-{name}-gvx")
    theirs = [pictures.load(baselines / f"vtkjs_volumemapper_{r}.png") for r in references]
    between = round(pictures.differences(*theirs, np.full(ours.shape[:2], True))["psnr_db"], 1) if len(theirs) > 1 else None
    reference = min(theirs, key=lambda picture: np.mean((picture - ours) ** 2))
    seen = [np.abs(p - scene["background"]).max(2) > 2 / 255 for p in (ours, reference)]
    either, both = seen[0] | seen[1], seen[0] & seen[1]
    row = {"case": name, **pictures.differences(ours, reference, either),
           "overlap": round(float(both.sum() / either.sum()), 3), "offset": pictures.offset(reference, ours),
           "color": [[round(255 * float(v), 1) for v in p[either].mean(0)] for p in (ours, reference)],
           "baselines_apart_db": between}
    rows.append(row)
    print(row, flush=True)
    pictures.side_by_side(pictures.out / f"vtkjs-{name}.png", [ours, reference, 4 * np.abs(ours - reference)],
                          ["gvx", "vtk-js", "difference x4"])

table = ["| case | PSNR dB | mean | 95 % | overlap | offset px | mean colour gvx / vtk-js | its two baselines, dB |",
         "|---|---|---|---|---|---|---|---|"]
for r in rows:
    table.append(f"| {r['case']} | {r['psnr_db']} | {r['mean']} | {r['p95']} | {r['overlap']} | {r['offset'][0]}, "
                 f"{r['offset'][1]} | {' '.join(map(str, r['color'][0]))} / {' '.join(map(str, r['color'][1]))} | "
                 f"{r['baselines_apart_db'] or ''} |")
print("\n".join(table))
(pictures.out / "vtkjs.md").write_text("\n".join(table) + "\n")
(pictures.out / "vtkjs.json").write_text(json.dumps(rows, indent=1) + "\n")
