"""Many shots of a case, and the ballistic limit that shots give, computed or fired at a range."""

from __future__ import annotations

import csv
import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

from . import _ripstop
from .errors import CaseError, RunError, failed
from .progress import Progress, Receiver
from .table import Result, Table

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

    from .case import Case


def within(name: str, value: float, low: float, high: float) -> None:
    """Refuses a number outside its limits."""
    if not low <= value <= high:
        raise CaseError(f"error: {name}\n  expected: {low} to {high}\n  found: {value}\n  help: leave it out")


class Study(Result):
    """Result of a study: attributes of its JSON file, its table, its page."""

    #: Name of its files, and of what it counts.
    stem = ""
    units = ""

    def __init__(self, folder: Path, kept: bool) -> None:
        super().__init__(self._text(folder, "json"))
        #: Folder with its files; None where they were temporary.
        self.folder = folder if kept else None
        self._page = self._text(folder, "html")
        self._csv = self._text(folder, "csv")

    def _text(self, folder: Path, end: str) -> str:
        return (folder / f"{self.stem}.{end}").read_text("utf-8")

    @cached_property
    def table(self) -> Table:
        """Rows of its CSV file: shots of a batch or of a V50, points of a sweep; units stand in the names."""
        return Table.of_csv(self._csv)

    @property
    def page(self) -> str:
        return self._page

    def to_pandas(self) -> pandas.DataFrame:
        """The table as a pandas DataFrame."""
        return self.table.to_pandas()


class Shots(Study):
    """Shots of a case. `table` has a row for each: `velocity_m_s`, `outcome`, `residual_velocity_m_s`, `absorbed_energy_j`, `reason`, …

    Attributes are those of `shots.json`, the limit fitted to them: `mu` and `sigma` [m/s], `quantiles`, `residual`.
    """

    stem, units = "shots", "shots"

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws residual over impact velocity [m/s], Vs-Vr, with the fitted curve."""
        from . import plot

        return plot.residual(self.table, self.residual, ax)

    def plot_limit(self, ax: Axes | None = None) -> Axes:
        """Draws the chance of a perforation over velocity [m/s], from V0 to V100, with the shots."""
        from . import plot

        return plot.limit(self.mu, self.sigma, self.quantiles, self.table, ax)


class V50(Study):
    """V50 of a case: `v50_m_s`, its interval `low_m_s` to `high_m_s` at the confidence `level`, `sigma_m_s`, `thresholds`, `as_woven`, …

    `table` has a row for each shot that was fired.
    """

    stem, units = "v50", "thresholds"

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the chance of a perforation over velocity [m/s], from V0 to V100, with intervals and the shots."""
        from . import plot

        return plot.limit(self.v50_m_s, self.sigma_m_s, self.quantiles, self.table, ax)

    def plot_residual(self, ax: Axes | None = None) -> Axes:
        """Draws residual over impact velocity [m/s], Vs-Vr."""
        from . import plot

        return plot.residual(self.table, self.residual, ax)

    def __repr__(self) -> str:
        if self.v50_m_s is None:
            return "<V50: none>"
        return f"<{self.quantity} {self.v50_m_s:.4g} m/s, {self.low_m_s or 0:.4g} to {self.high_m_s or float('inf'):.4g} m/s>"


class Sweep(Study):
    """Shots or V50 over a grid. `table` has a row for each point; columns of the factors are their JSON pointers."""

    stem, units = "sweep", "points"

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the response over the first factor, a line for each combination of the others."""
        from . import plot

        return plot.sweep(self.table, self.response, ax)


class Fit(Result):
    """Ballistic limit from a table of shots: `mu`, `sigma`, `quantiles`, `arithmetic`, `residual`, `notes`, in the unit `unit`."""

    def __init__(self, summary: str, page: str, table: Table | None) -> None:
        super().__init__(summary)
        self._page, self.table = page, table

    @property
    def page(self) -> str:
        return self._page

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the chance of a perforation over velocity, from V0 to V100, with intervals, and with the shots where they were given as columns."""
        from . import plot

        return plot.limit(self.mu, self.sigma, self.quantiles, self.table, ax, unit=self.unit)


S = TypeVar("S", bound=Study)


@contextmanager
def _folder(out: str | os.PathLike[str] | None) -> Iterator[tuple[Path, bool]]:
    """Folder of a study, and whether it stays: one of its own goes, unless what lies there can be gone on with."""
    folder = Path(out) if out is not None else Path(tempfile.mkdtemp(prefix="ripstop-"))
    try:
        yield folder, out is not None
    except KeyboardInterrupt:
        raise
    except BaseException:
        if out is None:
            shutil.rmtree(folder, ignore_errors=True)
        raise
    else:
        if out is None:
            shutil.rmtree(folder, ignore_errors=True)


def study(
    kind: type[S],
    case: _ripstop.Case,
    request: Mapping[str, Any],
    *,
    seed: int | None = None,
    level: float = 0.9,
    backend: Literal["auto", "cpu", "gpu"] = "cpu",
    adapter: str | None = None,
    precision: Literal["f64", "f32"] | None = None,
    threads: int | None = None,
    out: str | os.PathLike[str] | None = None,
    resume: bool = False,
    progress: bool | Receiver | None = None,
) -> S:
    """Runs a study. These options are those of `shots`, `v50` and `sweep`.

    `seed`: number that all draws come from; /variability/seed of the case without. `level`: two-sided confidence of the intervals. `threads`: shots
    at a time; all cores without; results do not depend on it. `backend`, `adapter`, `precision`, `progress`: as of `Case.run`. `out`: folder for the
    files of the command; a study that lies there goes on, after Ctrl-C, a kill or a full disk; a temporary folder without. `resume`: only go on,
    never begin.

    Raises CaseError, DeviceError, RunError without a V50, and Interrupted after Ctrl-C, with its `folder`.
    """
    import json

    within("level", level, 1e-9, 0.9999)
    whole = json.dumps({**request, "seed": seed, "level": level, "resume": resume})
    with _folder(out) as (folder, kept):
        with Progress(progress, kind.units) as show:
            missing, failure, ended = _ripstop.study(case, whole, folder, backend, adapter, precision, threads, show)
        if failure is not None:
            text = f"interrupted; rows so far: {folder}\n  help: the same call with out={str(folder)!r} goes on"
            raise failed(failure, text=text, folder=str(folder))
        result = kind(folder, kept)
        if missing is not None:
            raise failed(RunError(missing), result)
    return result


def v50_request(count: int | None, until_width: float | None, bracket: float) -> dict[str, Any]:
    """Request of a V50, with what the command takes where nothing is said."""
    if count is not None:
        within("count", count, 1, 1_000_000)
    for name, part in (("until_width", until_width), ("bracket", bracket)):
        if part is not None:
            within(name, part, 1e-6, 1.0)
    width = 0.02 if until_width is None and count is None else until_width
    return {"kind": "v50", "count": 64 if count is None else count, "until_width": width, "bracket": bracket, "over": []}


def crossover(
    case: Case, warp_stretch: float | Iterable[float], weft_stretch: float | Iterable[float] = 1.0, law: str | None = None
) -> Table:
    """Unit cell of a case's fabric at every pair of stretches [-], unstretched is 1, as `ripstop crossover`.

    Columns: `warp_stretch`, `weft_stretch`, `warp_tension_n`, `weft_tension_n`, `contact_force_n`, `warp_height_mm`, `weft_height_mm`, `warp_strain`,
    `weft_strain`, `iterations`, `residual`. `law`: "published", "variational" or "kawabata"; that of the case without.
    """
    ends = [[float(s) for s in ([stretch] if isinstance(stretch, (int, float)) else stretch)] for stretch in (warp_stretch, weft_stretch)]
    for name, stretches in zip(("warp_stretch", "weft_stretch"), ends):
        for stretch in stretches:
            within(name, stretch, 1e-6, 2.0)
    return Table.of_bytes(*_ripstop.crossover(case._case, *ends, law))


def fit(
    data: str | os.PathLike[str] | Mapping[str, Iterable[Any]],
    *,
    unit: Literal["m/s", "ft/s"] | None = None,
    columns: Mapping[str, str] | None = None,
    spread: float | None = None,
    level: float = 0.9,
) -> Fit:
    """Ballistic limit of shots that perforated or were stopped, as `ripstop fit`.

    `data`: a CSV file, or columns by name (a dict, a pandas DataFrame): `velocity_m_s`, `perforated`, and if wanted `count` and
    `residual_velocity_m_s`. `unit`: of velocities whose heading has none. `columns`: headings of other names by velocity, perforated, count or
    residual. `spread`: largest spread of a further arithmetic V50, in the unit of the velocities. `level`: two-sided confidence of the intervals.

    Raises CaseError where the table cannot be read.
    """
    within("level", level, 1e-9, 0.9999)
    if spread is not None:
        within("spread", spread, 1e-9, 1e6)
    named = list((columns or {}).items())
    if isinstance(data, (str, os.PathLike)):
        return Fit(*_ripstop.fit(os.fspath(data), None, unit, named, spread, level), None)
    names = list(data)
    text = [names, *zip(*(list(data[name]) for name in names))]
    with tempfile.TemporaryDirectory(prefix="ripstop-") as folder:
        path = Path(folder, "shots.csv")
        with path.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows([_cell(cell) for cell in row] for row in text)
        found = _ripstop.fit(os.fspath(path), "shots", unit, named, spread, level)
        return Fit(*found, Table.of_csv(path.read_text("utf-8")))


def _cell(cell: Any) -> Any:
    """Cell of a table: 1 or 0 for a truth, nothing for NaN."""
    cell = cell.item() if hasattr(cell, "item") else cell
    if isinstance(cell, bool):
        return int(cell)
    return "" if isinstance(cell, float) and cell != cell else cell
