"""Prints a VTU file as the independent reader meshio sees it: one line per array, "kind name shape : values"."""
import sys

import meshio
import numpy as np

mesh = meshio.read(sys.argv[1])


def show(kind, name, values):
    values = np.asarray(values)
    numbers = " ".join(repr(float(value)) for value in values.ravel())
    print(f"{kind} {name} {'x'.join(map(str, values.shape))} : {numbers}")


show("points", "points", mesh.points)
for block in mesh.cells:
    show("cells", block.type, block.data)
for name, values in mesh.point_data.items():
    show("point_data", name, values)
for name, blocks in mesh.cell_data.items():
    show("cell_data", name, np.concatenate(blocks))
