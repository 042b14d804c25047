#!/usr/bin/python3
"""VTK's frames for bench/peers: vtkFixedPointVolumeRayCastMapper, told what to do as frames.h says.

    vtk_frames.py FILE.raw SIZE THREADS          SIZE^3 u8 voxels

A frame is the mapper's own steps, up to the picture in memory. What VTK does once for a volume (normals,
ranges of blocks of voxels) is done before the first that is measured. The voxels are given as the bytes they are: as
floats they take four times the memory and make the same picture.
"""

import ctypes
import json
import pathlib
import sys
import time

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "vtk_pictures"))
import peer  # noqa: E402

HAIR = 0.001  # frames.h: kHair


class VtkSystem:
    def __init__(self, path, size, threads):
        voxels = np.fromfile(path, np.uint8)
        if voxels.size != size**3:
            raise ValueError(f"{path}: holds {voxels.size} bytes instead of {size**3}")
        image = vtk.vtkImageData()
        image.SetDimensions(size, size, size)
        image.GetPointData().SetScalars(numpy_to_vtk(voxels, deep=True))
        self.mapper = vtk.vtkFixedPointVolumeRayCastMapper()
        self.mapper.SetInputData(image)
        self.mapper.AutoAdjustSampleDistancesOff()
        self.mapper.LockSampleDistanceToInputSpacingOff()
        self.mapper.SetSampleDistance(1)
        self.mapper.SetInteractiveSampleDistance(1)
        self.mapper.SetImageSampleDistance(1)
        self.mapper.IntermixIntersectingGeometryOff()
        self.mapper.SetNumberOfThreads(threads)
        self.volume = vtk.vtkVolume()
        self.volume.SetMapper(self.mapper)

    def look(self, view):
        self.view = view
        self.volume.SetProperty(peer.property_of(view, 1.0))
        self.renderer = peer.renderer_of(view)
        self.renderer.AddVolume(self.volume)
        self.window = vtk.vtkGenericOpenGLRenderWindow()
        self.window.SetSize(*view["size"])
        self.window.SetDesiredUpdateRate(1e-6)
        self.window.AddRenderer(self.renderer)
        self.aside = False
        self.frame(False)

    def frame(self, aside):
        view = self.view["camera"]
        right = HAIR * aside * peer.camera_axes(view)[0]
        camera = self.renderer.GetActiveCamera()
        camera.SetPosition(*(np.array(view["eye"]) + right))
        camera.SetFocalPoint(*(np.array(view["target"]) + right))
        self.renderer.ResetCameraClippingRange(self.volume.GetBounds())
        start = time.perf_counter()
        self.mapper.PerImageInitialization(self.renderer, self.volume, 0, [0] * 3, [0] * 3, [0] * 6)
        self.mapper.PerVolumeInitialization(self.renderer, self.volume)
        self.mapper.PerSubVolumeInitialization(self.renderer, self.volume, 0)
        self.mapper.RenderSubVolume()
        return 1e3 * (time.perf_counter() - start)

    def rgb(self):
        image = self.mapper.GetRayCastImage()
        memory, used = image.GetImageMemorySize(), image.GetImageInUseSize()
        address = int(image.GetImage().split("_")[1], 16)
        pixels = np.ctypeslib.as_array((ctypes.c_uint16 * (memory[0] * memory[1] * 4)).from_address(address))
        pixels = pixels.reshape(memory[1], memory[0], 4)[:used[1], :used[0], :3] / 32767.0
        left, bottom = image.GetImageOrigin()
        width, height = self.view["size"]
        picture = np.zeros((height, width, 3))
        picture[bottom:bottom + used[1], left:left + used[0]] = pixels
        return (np.clip(picture[::-1], 0, 1) * 255 + 0.5).astype(np.uint8)


system = VtkSystem(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
for line in sys.stdin:
    what, _, name = line.strip().partition(" ")
    if what == "view":
        system.look(json.loads(pathlib.Path(name).read_text()))
        print("ok", flush=True)
    elif what == "frame":
        system.aside = not system.aside
        print(system.frame(system.aside), flush=True)
    elif what == "save":
        pathlib.Path(name).write_bytes(system.rgb().tobytes())
        print("ok", flush=True)
    else:
        sys.exit(f"standard input: \"{line.strip()}\" is not view, frame or save")
