"""VTK's CPU ray caster, vtkFixedPointVolumeRayCastMapper, given a volume and a saved gvx scene.

Nothing is displayed: the mapper's own steps (PerImageInitialization, PerVolumeInitialization, PerSubVolumeInitialization,
RenderSubVolume) make the picture in memory, which is read from there. So neither an X server nor OpenGL is needed.
"""

import ctypes
import gzip
import os
import pathlib
import struct

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk


def read_nifti(path):
    """Voxels [z, y, x] and the 4x4 matrix from their indices (x, y, z) to the world."""
    data = gzip.open(path).read() if str(path).endswith(".gz") else pathlib.Path(path).read_bytes()
    size = struct.unpack_from("<8h", data, 40)[1:4]
    kind = {2: "u1", 4: "<i2", 16: "<f4", 512: "<u2"}[struct.unpack_from("<h", data, 70)[0]]
    slope, shift = struct.unpack_from("<2f", data, 112)
    if (slope, shift) not in ((1, 0), (0, 0)):
        raise ValueError(f"{path}: a scale is not handled here")
    q_code, s_code = struct.unpack_from("<2h", data, 252)
    to_world = np.eye(4)
    if s_code > 0:
        to_world[:3] = np.reshape(struct.unpack_from("<12f", data, 280), (3, 4))
    elif q_code > 0:
        pixdim = struct.unpack_from("<8f", data, 76)
        b, c, d = struct.unpack_from("<3f", data, 256)
        a = np.sqrt(max(0, 1 - b * b - c * c - d * d))
        turn = np.array([[a*a+b*b-c*c-d*d, 2*(b*c-a*d), 2*(b*d+a*c)],
                         [2*(b*c+a*d), a*a+c*c-b*b-d*d, 2*(c*d-a*b)],
                         [2*(b*d-a*c), 2*(c*d+a*b), a*a+d*d-b*b-c*c]])
        spacing = np.array([pixdim[1], pixdim[2], pixdim[3] * (-1 if pixdim[0] < 0 else 1)])
        to_world[:3, :3] = turn * spacing
        to_world[:3, 3] = struct.unpack_from("<3f", data, 268)
    else:
        to_world[:3, :3] = np.diag(struct.unpack_from("<8f", data, 76)[1:4])
    start = int(struct.unpack_from("<f", data, 108)[0])
    voxels = np.frombuffer(data, kind, size[0] * size[1] * size[2], start)
    return voxels.reshape(size[::-1]), to_world


def read_nrrd(path):
    """As read_nifti, of a detached header with raw data; the world is x right, y front, z up."""
    fields = dict(line.split(": ", 1) for line in pathlib.Path(path).read_text().splitlines() if ": " in line)
    size = [int(n) for n in fields["sizes"].split()]
    kind = {"int16": "<i2", "uint8": "u1", "float": "<f4", "uint16": "<u2"}[fields["type"]]
    to_world = np.eye(4)
    for axis, text in enumerate(fields["space directions"].replace("(", "").replace(")", "").split()):
        to_world[:3, axis] = [float(n) for n in text.split(",")]
    to_world[:3, 3] = [float(n) for n in fields["space origin"].strip("()").split(",")]
    names = fields.get("space", "").split("-")
    for axis, away in enumerate(("left", "posterior", "inferior")):
        if len(names) == 3 and names[axis] == away:
            to_world[axis] *= -1
    voxels = np.fromfile(pathlib.Path(path).parent / fields["data file"], kind).reshape(size[::-1])
    return voxels, to_world


def read_volume(path):
    return read_nrrd(path) if str(path).endswith(".nhdr") else read_nifti(path)


def image_of(voxels, spacing):
    # As floats the mapper looks values up in 32768 steps; bytes it would round to whole ones after interpolation.
    image = vtk.vtkImageData()
    image.SetDimensions(*voxels.shape[::-1])
    image.SetSpacing(*spacing)
    image.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(voxels, np.float32).ravel(), deep=True))
    return image


def property_of(scene, unit):
    function, lighting = scene["functions"][0], scene["lighting"]
    p = vtk.vtkVolumeProperty()
    colors, opacities = vtk.vtkColorTransferFunction(), vtk.vtkPiecewiseFunction()
    for value, *rgb in function["colors"]:
        colors.AddRGBPoint(value, *rgb)
    for value, opacity in function["opacities"]:
        opacities.AddPoint(value, opacity)
    p.SetColor(colors)
    p.SetScalarOpacity(opacities)
    p.SetScalarOpacityUnitDistance(unit)
    p.SetInterpolationTypeToLinear()
    p.SetShade(lighting["enabled"])
    p.SetAmbient(lighting["ambient"])
    p.SetDiffuse(lighting["diffuse"])
    p.SetSpecular(lighting["specular"])
    p.SetSpecularPower(lighting["shininess"])
    return p


def camera_axes(camera):
    forward = np.subtract(camera["target"], camera["eye"])
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, camera["up"])
    right /= np.linalg.norm(right)
    return right, np.cross(right, forward), forward


def renderer_of(scene):
    renderer = vtk.vtkRenderer()
    camera, view = renderer.GetActiveCamera(), scene["camera"]
    camera.SetPosition(*view["eye"])
    camera.SetFocalPoint(*view["target"])
    camera.SetViewUp(*view["up"])
    if "height" in view:
        camera.ParallelProjectionOn()
        camera.SetParallelScale(view["height"] / 2)
    else:
        camera.SetViewAngle(view["fov"])
    renderer.AutomaticLightCreationOff()
    right, up, forward = camera_axes(view)
    for index, light in enumerate(scene["lighting"]["lights"]):
        place = np.array(light["place"])
        if light["kind"] == "camera":
            place = place[0] * right + place[1] * up - place[2] * forward
        vtk_light = vtk.vtkLight()
        vtk_light.SetLightTypeToSceneLight()
        vtk_light.SetFocalPoint(0, 0, 0)
        vtk_light.SetPosition(*(1e4 * place))
        vtk_light.SetColor(*light["color"])
        # VTK multiplies a material's ambient by that of each light, which is black unless told.
        vtk_light.SetAmbientColor(*([float(index == 0)] * 3))
        renderer.AddLight(vtk_light)
    return renderer


def render(scene, voxels, to_world):
    """The picture [row, column, rgb], 0 to 1, and its opacity, of a scene that `gvx render --save-scene` wrote."""
    spacing = np.linalg.norm(to_world[:3, :3], axis=0)
    # VTK casts rays between the centres of the outermost voxels and knows no clip box along rotated axes, so the
    # scenes here are clipped to the same box in gvx.
    mapper = vtk.vtkFixedPointVolumeRayCastMapper()
    mapper.SetInputData(image_of(voxels, spacing))
    step = spacing.min() / scene["samples"]
    mapper.AutoAdjustSampleDistancesOff()
    mapper.LockSampleDistanceToInputSpacingOff()
    mapper.SetSampleDistance(step)
    mapper.SetInteractiveSampleDistance(step)
    mapper.SetImageSampleDistance(1)
    mapper.IntermixIntersectingGeometryOff()
    mapper.SetNumberOfThreads(os.cpu_count())
    if scene["mode"] == "maximum":
        mapper.SetBlendModeToMaximumIntensity()
    elif scene["mode"] == "minimum":
        mapper.SetBlendModeToMinimumIntensity()
    volume = vtk.vtkVolume()
    volume.SetMapper(mapper)
    volume.SetProperty(property_of(scene, scene["functions"][0].get("unitDistance", 0) or spacing.min()))
    matrix = vtk.vtkMatrix4x4()
    place = to_world.copy()
    place[:3, :3] /= spacing
    for row in range(4):
        for column in range(4):
            matrix.SetElement(row, column, place[row, column])
    volume.SetUserMatrix(matrix)

    renderer = renderer_of(scene)
    renderer.AddVolume(volume)
    window = vtk.vtkGenericOpenGLRenderWindow()
    width, height = scene["size"]
    window.SetSize(width, height)
    window.SetDesiredUpdateRate(1e-6)
    window.AddRenderer(renderer)
    renderer.ResetCameraClippingRange(volume.GetBounds())

    mapper.PerImageInitialization(renderer, volume, 0, [0] * 3, [0] * 3, [0] * 6)
    mapper.PerVolumeInitialization(renderer, volume)
    mapper.PerSubVolumeInitialization(renderer, volume, 0)
    mapper.RenderSubVolume()

    image = mapper.GetRayCastImage()
    memory, used = image.GetImageMemorySize(), image.GetImageInUseSize()
    address = int(image.GetImage().split("_")[1], 16)
    pixels = np.ctypeslib.as_array((ctypes.c_uint16 * (memory[0] * memory[1] * 4)).from_address(address))
    pixels = pixels.reshape(memory[1], memory[0], 4)[:used[1], :used[0]] / 32767.0
    left, bottom = image.GetImageOrigin()
    picture = np.zeros((height, width, 4))
    picture[bottom:bottom + used[1], left:left + used[0]] = pixels
    picture = picture[::-1]
    return picture[..., :3] + (1 - picture[..., 3:]) * np.array(scene["background"]), picture[..., 3]
