"""Prints a .vtm file as VTK reads it, a line for each data set: body/participant, nodes, elements, largest
displacement [m]."""
import sys

from vtkmodules.vtkIOXML import vtkXMLMultiBlockDataReader

reader = vtkXMLMultiBlockDataReader()
reader.SetFileName(sys.argv[1])
reader.Update()


def name_in(block, i):
    return block.GetMetaData(i).Get(block.NAME())


scene = reader.GetOutput()
for b in range(scene.GetNumberOfBlocks()):
    body = scene.GetBlock(b)
    for p in range(body.GetNumberOfBlocks()):
        grid = body.GetBlock(p)
        low, high = grid.GetPointData().GetArray("displacement").GetRange(-1)
        print(f"{name_in(scene, b)}/{name_in(body, p)} {grid.GetNumberOfPoints()} {grid.GetNumberOfCells()} {high!r}")
