#!/usr/bin/env python3
"""Gradients as VTK finds them, at points of a volume: vtkImageGradient's central differences at voxels, trilinear between
them (vtkProbeFilter), which are the normals that its volume mappers shade by.

    vtk_gradients.py NAME X Y Z        reads NAME.raw (u16) and NAME.points (f64), writes NAME.gradients (f64)
"""

import sys

import numpy
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

name, size = sys.argv[1], [int(n) for n in sys.argv[2:5]]
voxels = numpy.fromfile(name + ".raw", numpy.uint16).astype(numpy.float64)
image = vtk.vtkImageData()
image.SetDimensions(*size)
image.SetOrigin(0.5, 0.5, 0.5)
image.GetPointData().SetScalars(numpy_to_vtk(voxels))
gradient = vtk.vtkImageGradient()
gradient.SetInputData(image)
gradient.SetDimensionality(3)
places = vtk.vtkPoints()
places.SetDataTypeToDouble()
places.SetData(numpy_to_vtk(numpy.fromfile(name + ".points", numpy.float64).reshape(-1, 3)))
at = vtk.vtkPolyData()
at.SetPoints(places)
probe = vtk.vtkProbeFilter()
probe.SetInputData(at)
probe.SetSourceConnection(gradient.GetOutputPort())
probe.Update()
vtk_to_numpy(probe.GetOutput().GetPointData().GetScalars()).astype(numpy.float64).tofile(name + ".gradients")
