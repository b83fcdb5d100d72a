"""Reads frames.vtkhdf, and frames.pvd where there is one, with VTK's own readers and compares them with expected.json.

Arguments: the folder of a run. Prints what differs and exits with 1, or with 0.
"""

import json
import sys
import xml.etree.ElementTree as tree
from pathlib import Path

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOHDF import vtkHDFReader
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

# Single precision, and once more for the change of units.
CLOSE = 4e-7


def compare(place, grid, expected):
    """All points, cells and arrays of a part at one time; what is not expected must not be there either."""
    if "centre_mm" in expected:
        return solid(place, grid, expected)
    assert grid.GetNumberOfPoints() == len(expected["points_mm"]), f"{place}: {grid.GetNumberOfPoints()} points"
    assert grid.GetNumberOfCells() == expected["cells"], f"{place}: {grid.GetNumberOfCells()} cells"
    close(f"{place} points", vtk_to_numpy(grid.GetPoints().GetData()), expected["points_mm"])
    if "corners" in expected:
        corners = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4)
        assert (corners == np.array(expected["corners"])).all(), f"{place}: corners"
    for kind, data in (("of_points", grid.GetPointData()), ("of_cells", grid.GetCellData())):
        names = {data.GetArrayName(n) for n in range(data.GetNumberOfArrays())}
        assert names == set(expected[kind]), f"{place}: arrays {sorted(names)}"
        for name in names:
            close(f"{place} {name}", vtk_to_numpy(data.GetArray(name)), expected[kind][name])


def solid(place, grid, expected):
    """A body of revolution that does not spin: its points lie around its axis, and all move alike."""
    points = vtk_to_numpy(grid.GetPoints().GetData())
    assert grid.GetNumberOfCells() > 100, place
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    size = np.ptp(points, axis=0).max()
    assert np.abs(middle - expected["centre_mm"]).max() < 2e-3 * size, f"{place}: centre {middle}"
    velocity = vtk_to_numpy(grid.GetPointData().GetArray("velocity_m_s"))
    speed = np.linalg.norm(expected["velocity_m_s"])
    assert np.abs(velocity.mean(axis=0) - expected["velocity_m_s"]).max() < 1e-2 * speed, f"{place}: velocity"
    assert grid.GetPointData().HasArray("displacement_mm") == 1, place


def close(place, got, expected):
    expected = np.array(expected, dtype=float)
    assert got.shape == expected.shape, f"{place}: shape {got.shape}, expected {expected.shape}"
    limit = CLOSE * np.abs(expected).max(initial=0.0)
    error = np.abs(got - expected).max(initial=0.0)
    assert error <= limit, f"{place}: off by {error}, at most {limit} is rounding"


def hdf(folder, frames):
    reader = vtkHDFReader()
    reader.SetFileName(str(folder / "frames.vtkhdf"))
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    close("time steps", np.array(times), [frame["time_us"] for frame in frames])
    # Backwards, so that no step is right because it comes after another.
    for time, frame in reversed(list(zip(times, frames))):
        reader.UpdateTimeStep(time)
        blocks = reader.GetOutputDataObject(0)
        assert blocks.GetNumberOfBlocks() == len(frame["parts"])
        for n, (name, part) in enumerate(frame["parts"].items()):
            assert blocks.GetMetaData(n).Get(blocks.NAME()) == name
            compare(f"vtkhdf, {time} µs, {name}", blocks.GetBlock(n), part)


def series(folder, frames):
    entries = tree.parse(folder / "frames.pvd").getroot().findall("./Collection/DataSet")
    expected = [(frame["time_us"], name, part) for frame in frames for name, part in frame["parts"].items()]
    assert len(entries) == len(expected), f"{len(entries)} files in frames.pvd"
    assert len(list((folder / "frames").iterdir())) == len(expected)
    for entry, (time, name, part) in zip(entries, expected):
        assert entry.get("name") == name and abs(float(entry.get("timestep")) - time) <= 1e-9 * time
        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(folder / entry.get("file")))
        reader.Update()
        compare(entry.get("file"), reader.GetOutput(), part)


def main(folder):
    window = vtkStringOutputWindow()
    vtkOutputWindow.SetInstance(window)
    frames = json.loads((folder / "expected.json").read_text())
    hdf(folder, frames)
    if (folder / "frames.pvd").exists():
        series(folder, frames)
    assert not window.GetOutput(), window.GetOutput()


if __name__ == "__main__":
    try:
        main(Path(sys.argv[1]))
    except AssertionError as error:
        sys.exit(str(error))
