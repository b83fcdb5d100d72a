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


def compare(place, grid, expected, start):
    """All points, cells and arrays of a part at one time; what is not expected must not be there either.

    start: the same part as it is expected in the first frame.
    """
    if "centre_mm" in expected:
        return solid(place, grid, expected, start)
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


def solid(place, grid, expected, start):
    """A closed surface, seen from outside, around the body's centre of mass, that moves and turns as the body does."""
    points = vtk_to_numpy(grid.GetPoints().GetData()).astype(float)
    centre, turn = np.array(expected["centre_mm"]), rotation(expected["rotation"])
    size = np.ptp(points, axis=0).max()
    volume, centroid = enclosed(place, points - centre, faces(grid))
    assert np.abs(centroid).max() < 2e-3 * size, f"{place}: centroid {centroid} from the centre of mass"
    own = (points - centre) @ turn
    before = np.array(start["centre_mm"]) + own @ rotation(start["rotation"]).T
    velocity = expected["velocity_m_s"] + 1e-3 * np.cross(expected["angular_velocity_rad_s"], points - centre)
    data = grid.GetPointData()
    assert data.GetNumberOfArrays() == 2 and grid.GetCellData().GetNumberOfArrays() == 0, f"{place}: arrays"
    close(f"{place} velocity_m_s", vtk_to_numpy(data.GetArray("velocity_m_s")), velocity)
    # Off by the rounding of positions, which lie as far out as the body is large.
    off = vtk_to_numpy(data.GetArray("displacement_mm")) - (points - before)
    assert np.abs(off).max() < 1e-5 * size, f"{place}: displacement off by {np.abs(off).max()}"
    if expected is start:
        # What touches the fabric may lie between two points.
        top = points[:, 2].max()
        assert -5e-3 * size < top < 1e-5 * size, f"{place}: begins {top} mm over the fabric"
    if "volume_mm3" in expected:
        # Chords of the surface lie inside of it.
        assert 0.985 < volume / expected["volume_mm3"] < 1.0 + 1e-5, f"{place}: {volume} mm³, {expected['volume_mm3']}"
    if expected.get("ends_mm"):
        flies = turn.T @ expected["velocity_m_s"]
        assert flies[2] > 0.8 * np.linalg.norm(flies), f"{place}: flies along {flies} in its own axes"
        for sign, end in zip((1, -1), expected["ends_mm"]):
            along = sign * own[:, 2]
            width = np.abs(own[along > along.max() - 1e-5 * size, 1]).max()
            assert abs(width - end) < 0.1, f"{place}: end {sign} is {width} mm wide, half, expected {end}"


def rotation(quaternion):
    """From the body's axes to those of the pack."""
    w, *v = quaternion
    x, y, z = v
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross


def faces(grid):
    """Corners of every face."""
    cells = grid.GetCells()
    corners, ends = (vtk_to_numpy(array) for array in (cells.GetConnectivityArray(), cells.GetOffsetsArray()))
    return [corners[a:b].tolist() for a, b in zip(ends, ends[1:])]


def enclosed(place, points, faces):
    """Volume and centroid of what faces enclose; each edge must belong to two, once in either direction."""
    edges = [edge for face in faces for edge in zip(face, face[1:] + face[:1])]
    assert len(set(edges)) == len(edges), f"{place}: an edge belongs to two faces in the same direction"
    assert {(b, a) for a, b in edges} == set(edges), f"{place}: the surface is open"
    assert set(range(len(points))) == {a for a, _ in edges}, f"{place}: points without a face"
    a, b, c = (points[[corner[n] for corner in triangles(faces)]] for n in range(3))
    parts = (a * np.cross(b, c)).sum(axis=1) / 6
    volume = parts.sum()
    assert volume > 0, f"{place}: faces look inwards, {volume} mm³"
    return volume, (parts[:, None] * (a + b + c) / 4).sum(axis=0) / volume


def triangles(faces):
    return [(face[0], *pair) for face in faces for pair in zip(face[1:], face[2:])]


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
            compare(f"vtkhdf, {time} µs, {name}", blocks.GetBlock(n), part, frames[0]["parts"][name])


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
        compare(entry.get("file"), reader.GetOutput(), part, frames[0]["parts"][name])


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
