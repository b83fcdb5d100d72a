"""Frames of a run: arrays, and meshes for PyVista."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray

from . import _ripstop

if TYPE_CHECKING:
    import pyvista

Array = NDArray[Any]

#: Names of the arrays in the library, here, shape of a row, number type, and factor to the unit in the name.
ARRAYS: tuple[tuple[str, str, tuple[int, ...], type, float], ...] = (
    ("displacement", "displacement_mm", (3,), np.float32, 1e3),
    ("velocity", "velocity_m_s", (3,), np.float32, 1.0),
    ("warp_tension", "warp_tension_n", (), np.float32, 1.0),
    ("weft_tension", "weft_tension_n", (), np.float32, 1.0),
    ("warp_strain", "warp_strain", (), np.float32, 1.0),
    ("weft_strain", "weft_strain", (), np.float32, 1.0),
    ("warp_crimp_height", "warp_crimp_height_mm", (), np.float32, 1e3),
    ("weft_crimp_height", "weft_crimp_height_mm", (), np.float32, 1e3),
    ("shear_angle", "shear_angle_rad", (), np.float32, 1.0),
    ("warp_alive", "warp_alive", (), np.uint8, 1.0),
    ("weft_alive", "weft_alive", (), np.uint8, 1.0),
)


@dataclass(frozen=True)
class Frame:
    """The whole scene at one time.

    `arrays`: by the names of the .vtu files that `ripstop run --frames` writes. Nodes: `displacement_mm` and `velocity_m_s`, (nodes, 3). Elements:
    `warp_tension_n`, `weft_tension_n`, `warp_strain`, `weft_strain`, `warp_crimp_height_mm`, `weft_crimp_height_mm`, `shear_angle_rad`,
    `warp_alive`, `weft_alive`, (elements,).
    """

    #: Time [µs].
    time_us: float
    arrays: dict[str, Array]
    #: Reference positions of the nodes [mm], (nodes, 3); x along the warp, y along the weft, z with the shot.
    reference_mm: Array = field(repr=False)
    #: Nodes at the corners of the elements, (elements, 4).
    corners: Array = field(repr=False)
    #: Ply of the elements, counted from the struck side, (elements,).
    ply: Array = field(repr=False)
    #: Centre of mass of the projectile [mm], its rotation (quaternion w, x, y, z) and its velocity [m/s]; None without one.
    projectile_mm: Array | None = None
    projectile_rotation: Array | None = None
    projectile_velocity_m_s: Array | None = None

    def __getattr__(self, name: str) -> Array:
        try:
            return self.__dict__["arrays"][name]  # type: ignore[no-any-return]
        except KeyError:
            raise AttributeError(f"a frame has no {name!r}") from None

    def mesh(self, *, broken: bool = False) -> pyvista.UnstructuredGrid:
        """The plies as a PyVista mesh of quadrilaterals, deformed, in mm, with all arrays. `broken`: with elements whose yarns are both broken."""
        import pyvista

        kept = np.ones(len(self.corners), bool) if broken else (self.arrays["warp_alive"] | self.arrays["weft_alive"]) != 0
        points = self.reference_mm + self.arrays["displacement_mm"]
        grid = pyvista.UnstructuredGrid({pyvista.CellType.QUAD: self.corners[kept]}, points)
        for name, values in self.arrays.items():
            if len(values) == len(points) and values.ndim == 2:
                grid.point_data[name] = values
            else:
                grid.cell_data[name] = values[kept]
        grid.cell_data["ply"] = self.ply[kept]
        return grid


class Frames(Sequence[Frame]):
    """Frames of a run, ascending in time."""

    def __init__(self, frames: Sequence[Frame]) -> None:
        self._frames = list(frames)

    @overload
    def __getitem__(self, at: int) -> Frame: ...
    @overload
    def __getitem__(self, at: slice) -> Frames: ...
    def __getitem__(self, at: int | slice) -> Frame | Frames:
        return Frames(self._frames[at]) if isinstance(at, slice) else self._frames[at]

    def __len__(self) -> int:
        return len(self._frames)

    def __iter__(self) -> Iterator[Frame]:
        return iter(self._frames)

    @property
    def time_us(self) -> Array:
        """Times of the frames [µs]."""
        return np.array([frame.time_us for frame in self._frames])

    def stack(self, name: str) -> Array:
        """An array of all frames together, (frames, …)."""
        return np.stack([frame.arrays[name] for frame in self._frames])

    @classmethod
    def of(cls, run: _ripstop.Run) -> Frames:
        """Frames that a run has kept."""
        found = run.frames()
        if found is None:
            return cls([])
        plies, reference, frames = found
        corners, ply = [], []
        for number, (columns, rows, first_node, _) in enumerate(plies):
            row, column = np.divmod(np.arange(rows * columns), columns)
            below = first_node + row * (columns + 1) + column
            corners.append(np.stack([below, below + 1, below + columns + 2, below + columns + 1], axis=1))
            ply.append(np.full(rows * columns, number, np.uint8))
        shared: dict[str, Any] = {
            "reference_mm": _array(reference, (3,), np.float32, 1e3),
            "corners": np.concatenate(corners),
            "ply": np.concatenate(ply),
        }

        def frame(time: float, of: dict[str, bytes], pose: list[float] | None) -> Frame:
            arrays = {name: _array(of[key], shape, kind, factor) for key, name, shape, kind, factor in ARRAYS}
            body = np.array(pose or [])
            parts = (body[:3] * 1e3, body[3:7], body[7:]) if pose else (None, None, None)
            return Frame(time * 1e6, arrays, **shared, projectile_mm=parts[0], projectile_rotation=parts[1], projectile_velocity_m_s=parts[2])

        return cls([frame(*one) for one in frames])


def _array(numbers: bytes, shape: tuple[int, ...], kind: type, factor: float) -> Array:
    """Numbers of these bytes, in the unit that the factor gives, rounded as in the .vtu files."""
    array = np.frombuffer(numbers, kind).reshape(-1, *shape)
    return array if factor == 1.0 else (array.astype(np.float64) * factor).astype(kind)
