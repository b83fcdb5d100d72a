"""Tables and results as arrays, dictionaries and pages."""

from __future__ import annotations

import csv
import html
import io
import json
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas

#: Height of a page in a notebook [px].
HEIGHT = 640


class Table(dict[str, NDArray[Any]]):
    """Columns by name, each a numpy array; units stand in the names."""

    def to_pandas(self) -> pandas.DataFrame:
        """The table as a pandas DataFrame."""
        import pandas

        return pandas.DataFrame(self)

    @classmethod
    def of_bytes(cls, names: Iterable[str], numbers: bytes) -> Table:
        """Table of float64 numbers, one column after the other."""
        names = list(names)
        columns = np.frombuffer(numbers, np.float64).reshape(len(names), -1) if names else ()
        return cls(zip(names, columns))

    @classmethod
    def of_csv(cls, text: str) -> Table:
        """Table of a CSV with a heading: float64 where all cells are numbers or empty (NaN), else text."""
        names, *rows = csv.reader(io.StringIO(text))
        columns = zip(*rows) if rows else ((),) * len(names)
        return cls((name, _column(cells)) for name, cells in zip(names, columns))


def _column(cells: Iterable[str]) -> NDArray[Any]:
    texts = np.array(list(cells), dtype=np.str_)
    try:
        return np.where(texts == "", "nan", texts).astype(np.float64)
    except ValueError:
        return texts


class Result:
    """Result with a summary, whose numbers are attributes too: `result.absorbed_energy_j` is `result.summary["absorbed_energy_j"]`.

    In a notebook it shows its page: verdict, figures, tables.
    """

    def __init__(self, summary: str) -> None:
        #: Everything that the command prints with --json.
        self.summary: dict[str, Any] = json.loads(summary)

    def __getattr__(self, name: str) -> Any:
        try:
            return self.__dict__["summary"][name]
        except KeyError:
            raise AttributeError(f"{type(self).__name__} has no {name!r}; `dir` lists what it has") from None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.summary]

    @property
    def page(self) -> str:
        """Page of the result: one HTML file that needs nothing else."""
        raise NotImplementedError

    def _repr_html_(self) -> str:
        frame = f'<iframe srcdoc="{html.escape(self.page)}" sandbox="allow-scripts allow-same-origin"'
        return f'{frame} style="width: 100%; height: {HEIGHT}px; border: 0"></iframe>'
