"""Tables and results: arrays, dictionaries, pages."""

from __future__ import annotations

import csv
import html
import io
import json
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas
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
