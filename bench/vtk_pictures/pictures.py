"""Running gvx, and saying how far two pictures are apart."""

import json
import math
import os
import pathlib
import subprocess

import numpy as np
from PIL import Image, ImageDraw

root = pathlib.Path(__file__).resolve().parents[2]
scenes = pathlib.Path(__file__).resolve().parent / "scenes"
out = root / "out/bench/vtk"
program = pathlib.Path(os.environ.get("GVX_PROGRAM", root / "build/release/apps/gvx/gvx"))
test_data = pathlib.Path(os.environ.get("GVX_TEST_DATA") or root / "../shared/data").resolve()


def source(name):
    """The volume file of a scene that is compared with VTK."""
    if name == "head":
        return root / "out/head.nhdr"
    return test_data / f"volumes/nifti/osv_{name}.nii.gz"


def build(source, store):
    """Makes out/bench/vtk/STORE from a volume file, always anew: a store may be of an older gvx."""
    subprocess.run([program, "build", source, "-o", out / store, "--force"], stdout=subprocess.DEVNULL, check=True)


def render(scene, name, *flags):
    """gvx's picture, 0 to 1, and the scene as gvx understood it."""
    saved, png = out / f"{name}.json", out / f"{name}.png"
    subprocess.run([program, "render", scene, "-o", png, "--save-scene", saved, "--quiet", *flags], check=True)
    return load(png), json.loads(saved.read_text())


def load(path):
    return np.asarray(Image.open(path).convert("RGB"), float) / 255


def save(path, picture):
    Image.fromarray((np.clip(picture, 0, 1) * 255 + 0.5).astype(np.uint8)).save(path)


def differences(a, b, seen):
    """PSNR of all pixels, and mean and 95th percentile of the absolute difference (of 255) where `seen`."""
    square = np.mean((a - b) ** 2)
    apart = np.abs(a - b)[seen] * 255
    return {"psnr_db": round(10 * math.log10(1 / square), 1) if square > 0 else math.inf,
            "mean": round(float(apart.mean()), 2), "p95": round(float(np.percentile(apart, 95)), 1)}


def side_by_side(path, pictures, labels=None):
    """Pictures of one size in a row; a difference is shown four times as strong, by its maker."""
    row = Image.fromarray((np.clip(np.concatenate(pictures, 1), 0, 1) * 255 + 0.5).astype(np.uint8))
    if labels:
        draw = ImageDraw.Draw(row)
        for i, label in enumerate(labels):
            draw.text((i * pictures[0].shape[1] + 5, 4), label, fill=(255, 255, 255))
    row.save(path)


def offset(a, b):
    """How many pixels (x, y) `b` lies beside `a`, by phase correlation, to a tenth or so."""
    a, b = (p.mean(2) - p.mean() for p in (a, b))
    cross = np.fft.fft2(b) * np.conj(np.fft.fft2(a))
    ramp = np.hypot(np.fft.fftfreq(a.shape[0])[:, None], np.fft.fftfreq(a.shape[1])[None])
    # Low frequencies alone: noise and the sampling's own pattern lie above.
    cross = cross / np.maximum(np.abs(cross), 1e-12) * np.exp(-(ramp / 0.15) ** 2)
    peak = np.real(np.fft.ifft2(cross))
    y, x = np.unravel_index(peak.argmax(), peak.shape)

    def fine(values, at):
        low, mid, high = (values[(at + d) % len(values)] for d in (-1, 0, 1))
        whole = at if at < len(values) / 2 else at - len(values)
        return whole + 0.5 * (low - high) / (low - 2 * mid + high)

    return round(float(fine(peak[y], x)), 2), round(float(fine(peak[:, x], y)), 2)


if __name__ == "__main__":  # The pictures of docs/measurements/vtk-2026-11.md.
    for made, name in (("head-unlit-2", "head"), ("bonsai-shaded-2", "bonsai"), ("engine-side-2", "engine"),
                       ("vtkjs-composite", "js-chest"), ("vtkjs-minimum", "js-minimum")):
        small = Image.open(out / f"{made}.png").convert("RGB").resize((840, 280), Image.LANCZOS)
        small.quantize(128, dither=0).save(root / f"docs/pictures/vtk-{name}.png", optimize=True)
