"""Many shots of a case, and the ballistic limit that shots give, computed or fired at a range."""

from __future__ import annotations

import csv
import json
import os
import shutil
import tempfile
from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypedDict, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from . import _ripstop
from .messages import Receiver, RunError, among, failed, shown, within
from .results import Result, Table

if TYPE_CHECKING:
    from .case import Case

Place = str | os.PathLike[str]  #: Path of a file or folder.


class Study(Result):
    """Result of a study: attributes of its JSON file, `table` of its CSV file, units in the names, `page`, `folder`."""

    stem, units = "", ""  #: Name of its files, and of what it counts.

    def __init__(self, folder: Path, kept: bool) -> None:
        text, self.page, rows = ((folder / f"{self.stem}.{end}").read_text("utf-8") for end in ("json", "html", "csv"))
        super().__init__(text)
        self.table = Table.of_csv(rows)
        #: Folder with its files; None where they were temporary.
        self.folder = folder if kept else None


class Shots(Study):
    """Shots of a case, a row of `table` for each: `velocity_m_s`, `outcome`, `residual_velocity_m_s`, `absorbed_energy_j`, `reason`, …

    Attributes are those of the limit fitted to them: `mu` and `sigma` [m/s], `quantiles`, `residual`; None where they give none.
    """

    stem, units, drawing = "shots", "shots", "residual"


class V50(Study):
    """V50 of a case: `v50_m_s`, `low_m_s` to `high_m_s` at the confidence `level`, `sigma_m_s`, `thresholds`, `as_woven`; `table` has the shots."""

    stem, units, drawing = "v50", "thresholds", "limit"

    def __repr__(self) -> str:
        ends = " to ".join("none" if end is None else f"{end:.4g}" for end in (self.low_m_s, self.high_m_s))
        return f"<{self.quantity} {self.v50_m_s:.4g} m/s, {ends} m/s>" if self.v50_m_s else f"<no {self.quantity}>"


class Sweep(Study):
    """Shots or V50 over a grid, a row of `table` for each point; the columns of the factors are their JSON pointers."""

    stem, units, drawing = "sweep", "points", "sweep"


class Fit(Result):
    """Ballistic limit of shots: `mu`, `sigma`, `quantiles`, `arithmetic`, `residual`, `notes`, in the unit `unit`. `table`: the shots, where columns were given."""

    drawing = "limit"

    def __init__(self, summary: str, page: str, table: Table) -> None:
        super().__init__(summary)
        self.page, self.table = page, table


S = TypeVar("S", bound=Study)


class Options(TypedDict, total=False):
    """Options of every study, see `study`."""

    seed: int | None
    level: float
    backend: Literal["auto", "cpu", "gpu"]
    adapter: str | None
    precision: Literal["f64", "f32"] | None
    threads: int | None
    out: Place | None
    resume: bool
    progress: bool | Receiver | None


def study(
    kind: type[S], case: _ripstop.Case, request: Mapping[str, Any], *, seed: int | None = None, level: float = 0.9,
    backend: Literal["auto", "cpu", "gpu"] = "cpu", adapter: str | None = None, precision: Literal["f64", "f32"] | None = None,
    threads: int | None = None, out: Place | None = None, resume: bool = False, progress: bool | Receiver | None = None,
) -> S:  # fmt: skip
    """Runs a study. These options are those of `Case.shots`, `Case.v50` and `Case.sweep`.

    `seed`: number that all draws come from; /variability/seed of the case without. `level`: two-sided confidence of intervals. `threads`: shots
    at a time, all cores without; results do not depend on it. `backend`, `adapter`, `precision`, `progress`: as of `Case.run`. `out`: folder for
    the files of the command, temporary without; a study that lies there goes on, after Ctrl-C, a kill or a full disk. `resume`: only go on.

    Raises CaseError, DeviceError, RunError where no limit was found, with everything else in `result`, and Interrupted, with `folder`.
    """
    within("level", level, 1e-9, 0.9999)
    usual = {"v50": False, "over": [], "velocity": None, "until_width": None, "bracket": 0.005, "refined": 0}
    options = {"seed": seed, "level": level, "resume": resume} | choice(backend, adapter, precision, threads)
    with ExitStack() as dropped:
        folder = Path(tempfile.mkdtemp(prefix="ripstop-") if out is None else out)
        if out is None:
            dropped.callback(shutil.rmtree, folder, ignore_errors=True)
        with shown(progress, kind.units) as show:
            missing, failure = _ripstop.study(case, json.dumps(usual | dict(request) | options | {"out": str(folder)}), show)
        if failure is not None:
            if isinstance(failure, KeyboardInterrupt):
                dropped.pop_all()  # what lies there can be gone on with
            text = f"interrupted; rows so far: {folder}\n  help: the same call with out={str(folder)!r} goes on"
            raise failed(failure, None, text, str(folder))
        result = kind(folder, out is not None)
    if missing is not None:
        raise failed(RunError(missing), result, "")
    return result


def choice(backend: str, adapter: str | None, precision: str | None, threads: int | None) -> dict[str, Any]:
    """Choice of a backend, checked."""
    among("backend", backend, ("auto", "cpu", "gpu"))
    among("precision", precision, ("f64", "f32"))
    within("threads", threads, 1, 1024)
    if backend != "cpu" and not any(os.environ.get(name, "").startswith("/") for name in ("XDG_RUNTIME_DIR", "WAYLAND_DISPLAY")):
        # A layer of Vulkan drivers looks for a display, and a library below it complains where it finds none.
        os.environ["WAYLAND_DISPLAY"] = "/nonexistent"
    return {"backend": backend, "adapter": adapter, "precision": precision, "threads": threads}


def crossover(case: Case, warp_stretch: ArrayLike, weft_stretch: ArrayLike = 1.0, law: str | None = None) -> Table:
    """Unit cell of a case's fabric at every pair of stretches [-], of which 1 is unstretched, as `ripstop crossover`.

    Columns: `warp_stretch`, `weft_stretch`, `warp_tension_n`, `weft_tension_n`, `contact_force_n`, `warp_height_mm`, `weft_height_mm`, `warp_strain`,
    `weft_strain`, `iterations`, `residual`. `law`: "published", "variational" or "kawabata"; that of the case without.
    """
    warp, weft = ([float(s) for s in np.atleast_1d(stretch)] for stretch in (warp_stretch, weft_stretch))
    for name, stretches in (("warp_stretch", warp), ("weft_stretch", weft)):
        for stretch in stretches:
            within(name, stretch, 1e-6, 2.0)
    return Table.of_bytes(*_ripstop.crossover(case.handle, warp, weft, law))


def fit(
    data: Place | Mapping[str, Iterable[Any]], *, unit: Literal["m/s", "ft/s"] | None = None, columns: Mapping[str, str] | None = None,
    spread: float | None = None, level: float = 0.9,
) -> Fit:  # fmt: skip
    """Ballistic limit of shots that perforated or were stopped, as `ripstop fit`.

    `data`: a CSV file, or columns by name (a dict, a DataFrame): `velocity_m_s`, `perforated`, and if wanted `count`, `residual_velocity_m_s`.
    `unit`: of velocities whose heading has none. `columns`: headings of other names by velocity, perforated, count or residual. `spread`: largest
    spread of a further arithmetic V50, in the unit of the velocities. `level`: two-sided confidence of intervals.

    Raises CaseError where the table cannot be read.
    """
    within("level", level, 1e-9, 0.9999)
    within("spread", spread, 1e-9, 1e6)
    options = (unit, list((columns or {}).items()), spread, level)
    if isinstance(data, (str, os.PathLike)):
        found = _ripstop.fit(os.fspath(data), os.fspath(data), *options)
        return Fit(*found, Table())
    with tempfile.TemporaryDirectory(prefix="ripstop-") as folder:
        path = Path(folder, "shots.csv")
        with path.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows([list(data), *zip(*(map(_cell, data[name]) for name in data))])
        return Fit(*_ripstop.fit(str(path), "shots", *options), Table.of_csv(path.read_text("utf-8")))


def _cell(cell: Any) -> Any:
    """Cell of a table: 1 or 0 for a truth, nothing for NaN."""
    cell = cell.item() if hasattr(cell, "item") else cell
    return int(cell) if isinstance(cell, bool) else "" if cell != cell else cell
