"""The volumes of bench/peers: SIZE^3 u8 voxels in FILE.raw with a header beside it, made once."""

import pathlib
import subprocess
import sys

import numpy as np
from scipy.ndimage import map_coordinates

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "vtk_pictures"))
import peer  # noqa: E402

SIZE = 512
WINDOW = -1024, 2000  # Hounsfield units that become 0 and 255


def make_foam(program, path):
    with path.open("wb") as out:
        subprocess.run([program, str(SIZE)], stdout=out, check=True)


def make_head(source, path):
    """The CT's box stretched to a cube: all of its voxels count, and all systems step by the same length."""
    voxels = peer.read_nrrd(source)[0]
    along = [np.linspace(0, n - 1, SIZE) for n in voxels.shape]
    with path.open("wb") as out:
        for z in along[0]:
            place = np.meshgrid([z], along[1], along[2], indexing="ij")
            # From slice to slice the same one or two: only they are held as floats.
            low = min(int(z), voxels.shape[0] - 2)
            place[0] = place[0] - low
            values = map_coordinates(voxels[low:low + 2].astype(np.float32), place, order=1, mode="nearest")
            values = (values[0] - WINDOW[0]) * (255 / (WINDOW[1] - WINDOW[0]))
            out.write(np.clip(np.rint(values), 0, 255).astype(np.uint8).tobytes())


def make(name, folder, root, foam_program):
    """FOLDER/NAME.raw and .nhdr, whose voxels' centres are the whole numbers of the world."""
    raw = folder / f"{name}.raw"
    if not raw.exists() or raw.stat().st_size != SIZE**3:
        part = folder / f"{name}.part"
        if name == "foam":
            make_foam(foam_program, part)
        else:
            if not (root / "out/head.nhdr").exists():
                subprocess.run([root / "tools/fetch_head", root / "out"], check=True)
            make_head(root / "out/head.nhdr", part)
        part.rename(raw)
    (folder / f"{name}.nhdr").write_text(
        f"NRRD0005\ntype: uint8\ndimension: 3\nsizes: {SIZE} {SIZE} {SIZE}\nspace: right-anterior-superior\n"
        f"space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n"
        f"data file: {name}.raw\n")
    return raw
