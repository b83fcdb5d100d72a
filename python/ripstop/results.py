"""Results: arrays, dictionaries, pages, and the run of one shot with its frames."""

from __future__ import annotations

import csv
import html
import io
import json
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _ripstop

if TYPE_CHECKING:
    import pandas
    import pyvista
    from matplotlib.axes import Axes

TEXT = {"outcome", "reason", "trust", "yarn"}  #: Columns of text.
HEIGHT = 640  #: Height of a page in a notebook [px].


class Table(dict[str, NDArray[Any]]):
    """Columns by name, each a numpy array; units stand in the names."""

    def to_pandas(self) -> pandas.DataFrame:
        """The table as a pandas DataFrame."""
        import pandas

        return pandas.DataFrame(self)

    @classmethod
    def of_bytes(cls, names: list[str], numbers: bytes) -> Table:
        """Table of float64 numbers, one column after the other."""
        return cls(zip(names, np.frombuffer(numbers, np.float64).reshape(len(names), -1))) if names else cls()

    @classmethod
    def of_csv(cls, text: str) -> Table:
        """Table of a CSV with a heading: numbers as float64, NaN where a cell is empty."""
        names, *rows = csv.reader(io.StringIO(text))
        columns = ((name, np.array([row[at] for row in rows], np.str_)) for at, name in enumerate(names))
        return cls((name, cells if name in TEXT else _numbers(cells)) for name, cells in columns)


def _numbers(cells: NDArray[np.str_]) -> NDArray[Any]:
    try:
        return np.where(cells == "", "nan", cells).astype(np.float64)
    except ValueError:
        return cells  # values of a factor of a sweep may be words


class Result:
    """Result with a summary and a page. `result.v50_m_s` is `result.summary["v50_m_s"]`. In a notebook it shows its page: verdict, figures, tables."""

    summary: dict[str, Any]  #: Everything that the command prints with --json.
    page: str  #: The page that the command writes: one HTML file that needs nothing else.
    table: Table  #: The table that comes with it.
    drawing: str  #: Its plot in `ripstop.plot`.

    def __init__(self, summary: str) -> None:
        self.summary = json.loads(summary)

    def __getattr__(self, name: str) -> Any:
        try:
            return self.__dict__["summary"][name]
        except KeyError:
            raise AttributeError(f"{type(self).__name__} has no {name!r}; `dir` lists what it has") from None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.summary]

    def to_pandas(self) -> pandas.DataFrame:
        """Its table as a pandas DataFrame."""
        return self.table.to_pandas()

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws it: the velocity of a run, Vs-Vr of shots, V0 to V100 of a limit, the response of a sweep. `ripstop.plot` has more."""
        from . import plot

        axes: Axes = getattr(plot, self.drawing)(self, ax)
        return axes

    def _repr_html_(self) -> str:
        frame = f'<iframe srcdoc="{html.escape(self.page)}" sandbox="allow-scripts"'
        return f'{frame} style="width: 100%; height: {HEIGHT}px; border: 0"></iframe>'


@dataclass(frozen=True)
class Frame:
    """The whole scene at one time.

    `arrays` have the names of the .vtu files that `ripstop run --frames` writes. Of nodes, (nodes, 3): `displacement_mm`, `velocity_m_s`. Of
    elements, (elements,): `warp_tension_n`, `warp_strain`, `warp_crimp_height_mm`, `warp_alive`, the same of the weft, `shear_angle_rad`, `ply`,
    which counts from the struck side.
    """

    time_us: float  #: Time [µs].
    arrays: Table
    #: Reference positions of the nodes [mm], (nodes, 3): x along the warp, y along the weft, z with the shot.
    reference_mm: NDArray[np.float32] = field(repr=False)
    #: Nodes at the corners of the elements, (elements, 4).
    corners: NDArray[np.int64] = field(repr=False)
    #: Projectile: `position_mm`, `rotation` (quaternion w, x, y, z), `velocity_m_s`; empty without one.
    projectile: Table

    def mesh(self, *, broken: bool = False) -> pyvista.UnstructuredGrid:
        """The plies as a PyVista mesh of quadrilaterals, deformed, in mm. `broken`: with elements in which no yarn carries load any more."""
        import pyvista

        kept = broken | (self.arrays["warp_alive"] | self.arrays["weft_alive"]).astype(bool)
        grid = pyvista.UnstructuredGrid({pyvista.CellType.QUAD: self.corners[kept]}, self.reference_mm + self.arrays["displacement_mm"])
        for name, values in self.arrays.items():
            of, chosen = (grid.point_data, values) if values.ndim == 2 else (grid.cell_data, values[kept])
            of[name] = chosen
        return grid


class Run(Result):
    """Result of one shot: attributes of `summary.json`, histories as arrays, frames.

    Units stand in the names: `residual_velocity_m_s`, `stop_time_us`, `max_deflection_mm`, `absorbed_energy_j`, `peak_contact_force_n`. `outcome` is
    "perforated", "stopped", "rebounded" or "running" (undecided). `trust["advice"]` says how far to trust them.
    """

    drawing = "velocity"

    def __init__(self, handle: _ripstop.Run) -> None:
        super().__init__(handle.summary())
        self._handle = handle

    def __repr__(self) -> str:
        return f"<Run {self.title}: {self.verdict}>"

    @property
    def verdict(self) -> str:
        """Verdict in a line, as `ripstop run` prints it."""
        return self._handle.verdict()

    @cached_property
    def history(self) -> Table:
        """Columns of `history.csv`, (rows,): `time_us`, `projectile_velocity_m_s`, `contact_force_n`, energies [J], and more."""
        return Table.of_bytes(*self._handle.history())

    @property
    def table(self) -> Table:  # type: ignore[override]
        """The history."""
        return self.history

    def table_of(self, name: str) -> Table:
        """Columns of another table: "events" (yarn failures), "plies" (of a pack, at the times of the history), "profiles" (deflection)."""
        return Table.of_csv(self._handle.table(name))

    @cached_property
    def page(self) -> str:  # type: ignore[override]
        """The page `report.html`, without its playback, with which `run(out=)` writes it."""
        return self._handle.page()

    @cached_property
    def frames(self) -> list[Frame]:
        """Frames that `run(frames=)` asked for, ascending in time."""
        plies, reference, frames = self._handle.frames() or ([], b"", [])
        corners = [np.empty((0, 4), np.int64)]
        for columns, rows, first in plies:
            row, column = np.divmod(np.arange(rows * columns), columns)
            below = first + row * (columns + 1) + column
            corners.append(below[:, None] + [0, 1, columns + 2, columns + 1])
        ply = np.repeat(np.arange(len(plies), dtype=np.uint8), [rows * columns for columns, rows, _ in plies])

        def array(name: str, numbers: bytes) -> NDArray[Any]:
            flat = np.frombuffer(numbers, np.uint8 if name.endswith("alive") else np.float32)
            return flat.reshape(-1, 3) if name in ("displacement_mm", "velocity_m_s") else flat

        def frame(time_us: float, arrays: dict[str, bytes], pose: list[float] | None) -> Frame:
            at = np.array(pose or [])
            body = {"position_mm": 1e3 * at[:3], "rotation": at[3:7], "velocity_m_s": at[7:]} if pose else {}
            named = Table({name: array(name, numbers) for name, numbers in arrays.items()} | {"ply": ply})
            return Frame(time_us, named, array("displacement_mm", reference), np.concatenate(corners), Table(body))

        return [frame(*one) for one in frames]
