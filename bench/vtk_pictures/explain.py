#!/usr/bin/python3
"""Why gvx and its peers differ: a plain ray caster in numpy with one rule of the peer's at a time, beside both pictures.

    bench/vtk_pictures/run explain           after `run` and `run vtkjs`, whose pictures it takes

Every fourth pixel along both axes. Lights are the camera's. gvx's rules are: opacities of the step by Beer's law, lit by
surface certainty, a gradient's factor on the extinction, no clipping in depth.
"""

import json

import numpy as np

import peer
import pictures

STRIDE = 4


def at(voxels, place):
    """Trilinear, held at the border; `place` is [..., xyz] in voxels."""
    size = np.array(voxels.shape[::-1])
    place = np.clip(place, 0, size - 1)
    low = np.minimum(place.astype(int), size - 2)
    fx, fy, fz = np.moveaxis(place - low, -1, 0)
    x, y, z = np.moveaxis(low, -1, 0)
    line = lambda dy, dz: voxels[z + dz, y + dy, x] * (1 - fx) + voxels[z + dz, y + dy, x + 1] * fx
    return (line(0, 0) * (1 - fy) + line(1, 0) * fy) * (1 - fz) + (line(0, 1) * (1 - fy) + line(1, 1) * fy) * fz


def lit_voxels(voxels, to_index, ahead, lighting):
    """What VTK interpolates: body and glint of each voxel, by its own normal and one direction to the eye."""
    world = np.stack(np.gradient(voxels)[::-1], -1) @ to_index[:3, :3].astype(np.float32)
    steep = np.linalg.norm(world, axis=-1)
    facing = np.abs(world @ ahead.astype(np.float32)) / np.maximum(steep, 1e-9)
    body = lighting["ambient"] + lighting["diffuse"] * facing
    return body, lighting["specular"] * facing ** lighting["shininess"]


def cast(scene, voxels, to_world, step, *, certainty=True, reach=0.5, forward=False, factor_on_opacity=False, phong=False,
         at_voxels=False, bytes_table=False, depth=None):
    """Gradients reach `reach` voxels to both sides, or, if `forward`, to the next voxel on one side; `phong` takes the
    angle to the mirrored light instead of that to the half vector; `at_voxels` lights voxels and interpolates that;
    `bytes_table` cuts a step's opacity to 8 bits before it is interpolated; `depth` is a near and far plane."""
    voxels = voxels.astype(np.float32)
    width, height = scene["size"]
    right, up, ahead = peer.camera_axes(scene["camera"])
    y, x = np.mgrid[0:height:STRIDE, 0:width:STRIDE]
    pixel = 2 * np.tan(np.radians(scene["camera"]["fov"] / 2)) / height
    ray = ahead + ((x + 0.5 - width / 2) * pixel)[..., None] * right + ((height / 2 - y - 0.5) * pixel)[..., None] * up
    length = np.linalg.norm(ray, axis=-1)
    ray /= length[..., None]
    to_index = np.linalg.inv(to_world)
    eye = to_index[:3, :3] @ scene["camera"]["eye"] + to_index[:3, 3]
    along = ray @ to_index[:3, :3].T
    size = np.array(voxels.shape[::-1])
    clip = np.reshape(scene["clip"], (2, 3)) * size - 0.5
    with np.errstate(divide="ignore"):
        one, other = (clip[0] - eye) / along, (clip[1] - eye) / along
    begin, end = np.minimum(one, other).max(-1), np.maximum(one, other).min(-1)
    hit = end > begin
    if depth:
        begin, end = np.maximum(begin, depth[0] * length), np.minimum(end, depth[1] * length)
    function, lighting = scene["functions"][0], scene["lighting"]
    colors, opacities = np.array(function["colors"]), np.array(function["opacities"])
    spacing = np.linalg.norm(to_world[:3, :3], axis=0)
    unit = function.get("unitDistance", 0) or spacing.min()
    values = np.concatenate([colors[:, 0], opacities[:, 0]])
    soft = (values.max() - values.min()) / 40
    color = lambda v: np.stack([np.interp(v, colors[:, 0], colors[:, i]) for i in (1, 2, 3)], -1)
    gathered, seen = np.zeros(hit.shape + (3,)), np.zeros(hit.shape)
    least = np.full(hit.shape, np.inf)
    near = begin[hit].min()
    if at_voxels:
        body_at, glint_at = lit_voxels(voxels, to_index, ahead, lighting)
    for t in np.arange(near + step / 2, end[hit].max(), step):
        inside = hit & (begin <= t) & (t < end) & (seen < 0.999)
        if not inside.any():
            continue
        place = eye + t * along[inside]
        value = at(voxels, place)
        if scene["mode"] == "minimum":
            least[inside] = np.minimum(least[inside], value)
            continue
        opacity = np.interp(value, opacities[:, 0], opacities[:, 1])
        rgb = color(value)
        extinction = -np.log1p(-np.minimum(opacity, 0.9999)) * step / unit
        if bytes_table:
            entries = np.arange(256)
            table = -np.expm1(np.log1p(-np.minimum(np.interp(entries, *opacities.T), 0.9999)) * step / unit)
            extinction = -np.log1p(-np.minimum(np.interp(value, entries, np.floor(table * 255) / 255), 0.9999))
        glint = 0
        if lighting["enabled"] or "gradients" in function:
            if forward:
                gradient = np.stack([at(voxels, place + d) - value for d in np.eye(3)], -1)
            else:
                gradient = np.stack([at(voxels, place + d) - at(voxels, place - d)
                                     for d in reach * np.eye(3)], -1) / (2 * reach)
            world = gradient @ to_index[:3, :3]
            steep = np.linalg.norm(world, axis=-1)
            factor = 1
            if "gradients" in function:
                factor = np.interp(steep, *np.array(function["gradients"]).T)
            if not factor_on_opacity:
                extinction *= factor
            else:
                extinction = -np.log1p(-np.minimum(factor * -np.expm1(-extinction), 0.9999))
            if at_voxels:
                rgb = rgb * at(body_at, place)[..., None]
                rgb, glint = np.minimum(rgb + at(glint_at, place)[..., None], 1), 0
            elif lighting["enabled"]:
                surface = np.sum(gradient**2, -1)
                surface = surface / (surface + soft**2) if certainty else 1
                normal = world / np.maximum(steep, 1e-9)[..., None]
                to_light = -ahead
                half = to_light - ray[inside]
                half /= np.linalg.norm(half, axis=-1, keepdims=True)
                facing = 1 + surface * (np.abs(normal @ to_light) - 1)
                if phong:
                    mirrored = 2 * (normal @ to_light)[..., None] * normal - to_light
                    shine = np.maximum(-np.sum(mirrored * ray[inside], -1), 0) ** lighting["shininess"]
                else:
                    shine = np.abs(np.sum(normal * half, -1)) ** lighting["shininess"]
                rgb = rgb * (lighting["ambient"] + lighting["diffuse"] * facing)[..., None]
                glint = (surface * lighting["specular"] * shine)[..., None]
        weight = (1 - seen[inside]) * -np.expm1(-extinction)
        gathered[inside] += weight[..., None] * (rgb + glint)
        seen[inside] += weight
    if scene["mode"] == "minimum":
        least = np.where(np.isfinite(least), least, 0)
        seen = np.where(hit, np.interp(least, opacities[:, 0], opacities[:, 1]), 0)
        gathered = color(least) * seen[..., None]
    return gathered + (1 - seen)[..., None] * scene["background"]


def case(name, reference, volume, variants):
    """`reference` is the peer's picture of scene `name`; a variant is a label, a step, and options of cast()."""
    scene = json.loads((pictures.out / f"{name}-gvx.json").read_text())
    volume = peer.read_volume(volume)
    few = lambda picture: picture[::STRIDE, ::STRIDE]
    ours, theirs = few(pictures.load(pictures.out / f"{name}-gvx.png")), few(pictures.load(reference))
    seen = np.abs(theirs - scene["background"]).max(2) > 2 / 255
    rows.append((name, "gvx itself", "", pictures.differences(ours, theirs, seen)["psnr_db"], ours[seen].mean() * 255))
    for label, step, options in variants:
        picture = np.clip(cast(scene, *volume, step, **options), 0, 1)
        rows.append((name, label, pictures.differences(picture, ours, seen)["psnr_db"],
                     pictures.differences(picture, theirs, seen)["psnr_db"], picture[seen].mean() * 255))
        print(*rows[-1], flush=True)
    rows.append((name, "the peer itself", rows[-len(variants) - 1][3], "", theirs[seen].mean() * 255))


rows = []
step = 0.25
for name in ("head-shaded", "bonsai-shaded", "engine-shaded", "head-haze"):
    case(f"{name}-2", pictures.out / f"{name}-2-vtk.png", pictures.source(name.split("-")[0]), [
        ("gvx's rules", step, {}), ("gradients to a voxel on both sides", step, {"reach": 1}),
        ("and all matter lit as a surface", step, {"reach": 1, "certainty": False}),
        ("lit at voxels, held at white at each sample", step, {"at_voxels": True})])

baseline = lambda name: pictures.test_data / f"baselines/vtkjs_volumemapper_{name}.png"
# The camera was reset before it was raised, and its near and far planes stayed: of a depth of 139.5 seen from 810.6,
# with one per cent and a twentieth of the depth to spare.
case("vtkjs-minimum", baseline("core/testMinimumIntensityProjection"), pictures.out / "headsq.nhdr", [
    ("gvx's rules", 0.5, {}), ("near and far as before the camera was raised", 0.5, {"depth": (726.5, 896.2)})])
case("vtkjs-lighting", baseline("opengl/testLighting"), pictures.out / "headsq.nhdr", [
    ("gvx's rules", 0.5, {}), ("all matter lit as a surface", 0.5, {"certainty": False}),
    ("and gradients to the next voxel", 0.5, {"certainty": False, "forward": True}),
    ("and highlights by the mirrored light", 0.5, {"certainty": False, "forward": True, "phong": True}),
    ("and step 2, the gradient's factor on its opacity", 2.0,
     {"certainty": False, "forward": True, "phong": True, "factor_on_opacity": True})])
case("vtkjs-composite", baseline("core/testComposite_2"), pictures.out / "lidc.nhdr", [
    ("gvx's rules, step 0.2", 0.2, {}), ("step 0.7", 0.7, {}),
    ("and its opacity as a byte", 0.7, {"bytes_table": True})])

table = ["| scene | rules | to gvx, dB | to the peer, dB | brightness |", "|---|---|---|---|---|"]
table += [f"| {name} | {label} | {ours} | {theirs} | {light:.1f} |" for name, label, ours, theirs, light in rows]
print("\n".join(table))
(pictures.out / "explain.md").write_text("\n".join(table) + "\n")
