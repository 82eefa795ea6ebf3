# SPDX-License-Identifier: MIT
#
# What VTK takes for a scene's transparent meshes, for vtk.sh: python3 vtk_frames.py FILE.glb WIDTH HEIGHT
# FRAMES. Prints JSON. Needs Debian's python3-vtk9 and a display.
#
#   dual     dual depth peeling, every layer: exact
#   sort     polygons sorted by depth on the CPU each frame, blended: wrong where they intersect
#   weighted VTK's own order-independent pass: wrong wherever several fragments meet
#   floor    blended as they come
import json
import math
import statistics
import struct
import sys
import time

import vtk


def read_gltf(path):
    with open(path, "rb") as file:
        data = file.read()
    size = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20:20 + size])


def camera_of(gltf):
    """Eye and direction of the first camera's node, which has a matrix or a rigid pose of its own."""
    node = next(n for n in gltf["nodes"] if n.get("camera") == 0)
    if "matrix" in node:
        m = node["matrix"]
        eye, back = m[12:15], m[8:11]
    else:
        x, y, z, w = node.get("rotation", [0, 0, 0, 1])
        eye = node.get("translation", [0, 0, 0])
        back = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]
    return eye, [-c for c in back], math.degrees(gltf["cameras"][0]["perspective"]["yfov"])


def polygons_of(path, gltf):
    """All blended triangles as one set, with a colour for each point."""
    reader = vtk.vtkGLTFReader()
    reader.SetFileName(path)
    reader.Update()
    append = vtk.vtkAppendPolyData()
    iterator = reader.GetOutput().NewIterator()
    iterator.InitTraversal()
    primitives = [p for mesh in gltf["meshes"] for p in mesh["primitives"]]
    index = 0
    while not iterator.IsDoneWithTraversal():
        material = gltf["materials"][primitives[index]["material"]]
        if material.get("alphaMode") == "BLEND":
            mesh = vtk.vtkPolyData()
            mesh.ShallowCopy(iterator.GetCurrentDataObject())
            normals = mesh.GetPointData().GetNormals()
            color = material.get("pbrMetallicRoughness", {}).get("baseColorFactor", [1, 1, 1, 1])
            colors = vtk.vtkUnsignedCharArray()
            colors.SetNumberOfComponents(4)
            colors.SetName("color")
            colors.SetNumberOfTuples(mesh.GetNumberOfPoints())
            for i, c in enumerate(color):
                colors.FillComponent(i, round(255 * c))
            mesh.GetPointData().Initialize()
            mesh.GetPointData().SetScalars(colors)
            if normals:
                mesh.GetPointData().SetNormals(normals)
            append.AddInputData(mesh)
        index += 1
        iterator.GoToNextItem()
    append.Update()
    return append.GetOutput()


def window_for(polygons, way, width, height):
    renderer = vtk.vtkRenderer()
    mapper = vtk.vtkPolyDataMapper()
    if way == "sort":
        sort = vtk.vtkDepthSortPolyData()
        sort.SetInputData(polygons)
        sort.SetDirectionToBackToFront()
        sort.SetDepthSortModeToParametricCenter()
        sort.SetCamera(renderer.GetActiveCamera())
        mapper.SetInputConnection(sort.GetOutputPort())
    else:
        mapper.SetInputData(polygons)
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.ForceTranslucentOn()
    renderer.AddActor(actor)
    renderer.SetUseDepthPeeling(way == "dual")
    renderer.SetMaximumNumberOfPeels(1 << 20)
    renderer.SetOcclusionRatio(0)
    if way == "weighted":
        steps = vtk.vtkRenderStepsPass()
        renderer.SetPass(steps)
        oit = vtk.vtkOrderIndependentTranslucentPass()
        oit.SetTranslucentPass(vtk.vtkTranslucentPass())
        steps.SetTranslucentPass(oit)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetAlphaBitPlanes(1)
    window.SetSize(width, height)
    window.AddRenderer(renderer)
    return window, renderer


def main():
    path, width, height, frames = sys.argv[1], *map(int, sys.argv[2:5])
    gltf = read_gltf(path)
    eye, direction, angle = camera_of(gltf)
    polygons = polygons_of(path, gltf)
    ways = ["dual", "sort", "weighted", "floor"]
    windows = {way: window_for(polygons, way, width, height) for way in ways}
    ms = {way: [] for way in ways}
    centre = polygons.GetCenter()
    for frame in range(frames + 2):  # two to warm up
        for way in ways:
            window, renderer = windows[way]
            camera = renderer.GetActiveCamera()
            turn = vtk.vtkTransform()  # a degree a frame about the middle
            turn.Translate(centre)
            turn.RotateY(frame)
            turn.Translate([-c for c in centre])
            camera.SetPosition(turn.TransformPoint(eye))
            camera.SetFocalPoint(turn.TransformPoint([e + d for e, d in zip(eye, direction)]))
            camera.SetViewAngle(angle)
            renderer.ResetCameraClippingRange()
            begin = time.perf_counter()
            window.Render()
            window.WaitForCompletion()
            if frame >= 2:
                ms[way].append(1000 * (time.perf_counter() - begin))
    print(json.dumps({
        "vtk": vtk.vtkVersion().GetVTKVersion(),
        "triangles": polygons.GetNumberOfPolys(),
        "results": [{"name": way, "ms": statistics.median(ms[way]), "frame_ms": ms[way]}
                    for way in ways]}, indent=1))


main()
