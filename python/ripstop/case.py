"""A case: what is to be computed. Keys and units are those of a case file, see docs/keys.md."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Literal

from . import _ripstop, studies
from .messages import Receiver, among, failed, refusal, shown, within
from .results import Run

if TYPE_CHECKING:
    from typing_extensions import Unpack

PARTS = ("pack", "projectile", "solver", "output")  #: Parts of a case whose keys may be keywords.


def plain(value: Any) -> Any:
    """Plain value of a numpy number or array, for JSON."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"a case has no {type(value).__name__}: {value!r}")


def sets(changes: Mapping[str, Any]) -> list[str]:
    """Changes as the command line takes them after --set."""
    return [f"{pointer}={json.dumps(value, default=plain)}" for pointer, value in changes.items()]


@lru_cache(maxsize=1)
def _keys() -> dict[str, list[str]]:
    """Parts of a case by the keys that they have."""
    schema = json.loads(_ripstop.schema())["properties"]
    keys: dict[str, list[str]] = {}
    for part in PARTS:
        for key in schema[part]["properties"]:
            keys.setdefault(key, []).append(part)
    return keys | {key: [] for key in schema}


def _document(keys: Mapping[str, Any]) -> dict[str, Any]:
    """Case of keywords."""
    document: dict[str, Any] = {"title": "a case", "sources": {"": "set by a program"}}
    for key, value in keys.items():
        parts = _keys().get(key)
        if parts == []:
            document[key] = value
        elif parts is not None and len(parts) == 1:
            document.setdefault(parts[0], {})[key] = value
        else:
            expected = f"{' or '.join(parts)}, a dict with it" if parts else "a key of a case, or of its pack, projectile, solver or output"
            raise refusal("keywords", expected, key, "docs/keys.md lists every key")
    if isinstance(document.get("fabric"), str):
        document["fabric"] = {"file": f"fabrics/{document['fabric']}.json"}
    return document


class Case:
    """A checked case. It does not change: `with_` gives another one.

    >>> ripstop.Case("shot.json")                                     # a file
    >>> ripstop.Case({"title": "a shot", "fabric": {...}, ...})       # what a file would hold
    >>> ripstop.Case(fabric="s-720", width_mm=40, height_mm=40, edges="clamped", shape="sphere", diameter_mm=6, mass_g=1, velocity_m_s=120)

    Keywords are keys of a case file, or of its pack, projectile, solver or output. `fabric` may be the name of one that comes with ripstop:
    s-720, s-728, km2-s706, kevlar29-s745, kevlar49-17x17, twaron-ct612, twaron-ct709. `name` names a case without a file in errors.

    Raises CaseError with everything that is wrong.
    """

    handle: _ripstop.Case  #: The case in the library.

    def __init__(self, source: str | os.PathLike[str] | Mapping[str, Any] | None = None, /, *, name: str = "case", **keys: Any) -> None:
        if source is not None and keys:
            raise refusal("Case", "a file, a dict or keywords", "two of them", "`with_` changes a case")
        if isinstance(source, (str, os.PathLike)):
            self.handle = _ripstop.Case.read(os.fspath(source))
        else:
            document = _document(keys) if source is None else source
            self.handle = _ripstop.Case.parse(name, json.dumps(document, default=plain), "", [])

    @classmethod
    def _of(cls, handle: _ripstop.Case) -> Case:
        case = cls.__new__(cls)
        case.handle = handle
        return case

    def with_(self, changes: Mapping[str, Any]) -> Case:
        """The case with changes by JSON pointer, as --set makes them: `case.with_({"/projectile/velocity_m_s": 140})`.

        Raises CaseError as a new case does.
        """
        return self._of(self.handle.with_sets(sets(changes)))

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, self.handle.parts()

    def __repr__(self) -> str:
        return f"<Case {self.title}>"

    @property
    def title(self) -> str:
        """Title, with the changes."""
        return self.handle.title

    @property
    def name(self) -> str:
        """Name of the file without its end, with the changes."""
        return self.handle.name

    @property
    def document(self) -> dict[str, Any]:
        """The case as run: what `case.json` beside its results holds."""
        document: dict[str, Any] = json.loads(self.handle.json())
        return document

    def check(self) -> dict[str, Any]:
        """What follows from the numbers of the case, without running it: the JSON of `ripstop check`.

        `fabrics` (with `breaking_load_n`, `wave_speed_m_s`), `areal_density_kg_m2`, `impact_energy_j`, `run` (`time_step_us`, `elements`,
        `memory_bytes`, …), `fields` with their sources, `warnings`.
        """
        sheet: dict[str, Any] = json.loads(self.handle.check())
        return sheet

    def run(
        self, backend: Literal["auto", "cpu", "gpu"] = "auto", *, precision: Literal["f64", "f32"] | None = None, threads: int | None = None,
        adapter: str | None = None, frames: int | None = None, out: studies.Place | None = None, progress: bool | Receiver | None = None,
    ) -> Run:  # fmt: skip
        """Runs the case, to the same bits as `ripstop run`.

        `backend`: "auto" takes a real GPU if there is one, else the processor. `adapter`: GPU by a part of its name or its number. `precision`:
        "f64", or "f32", the only one of a GPU. `threads`: all cores without; results do not depend on it. `frames`: frames in memory, evenly
        from impact to the end, up to twice as many; /output/frames of the case without. `out`: folder for the files that `ripstop run` writes,
        frames excepted. `progress`: see `ripstop.messages.shown`.

        Raises CaseError, DeviceError, RunError for a run that became unstable, and Interrupted after Ctrl-C; the last two have the results so
        far in `result`.
        """
        within("frames", frames, 0, 1e9)
        wanted = studies.choice(backend, adapter, precision, threads) | {"frames": frames, "out": None if out is None else os.fspath(out)}
        with shown(progress, self.title) as show:
            handle, failure = _ripstop.run(self.handle, json.dumps(wanted), show)
        run = Run(handle)
        if failure is not None:
            raise failed(failure, run, f"interrupted at {run.time_us:.4g} µs; `result` holds the results up to there")
        return run

    def shots(self, count: int = 1, *, velocity_m_s: tuple[float, float] | None = None, **options: Unpack[studies.Options]) -> studies.Shots:
        """Many shots, each with its own draws of /variability, as `ripstop shots`.

        `velocity_m_s`: ends of the range that impact velocities are spread over evenly; that of the case without. `options`: see
        `ripstop.studies.study`.
        """
        within("count", count, 1, 10_000_000)
        if velocity_m_s is not None and not 0 < velocity_m_s[0] < velocity_m_s[1] <= 5000:
            raise refusal("velocity_m_s", "two velocities in m/s, the lower first, such as (150, 250)", velocity_m_s, "at most 5000 m/s")
        request = {"count": count, "velocity": velocity_m_s}
        return studies.study(studies.Shots, self.handle, request, **options)

    def v50(
        self, count: int | None = None, *, until_width: float | None = None, bracket: float = 0.005, refined: int | None = None,
        **options: Unpack[studies.Options],
    ) -> studies.V50:  # fmt: skip
        """Velocity at which half of all shots perforate, with its interval, as `ripstop v50`.

        `count`: realisations at most, 64 without. `until_width`: stop once half the interval is at most this part of V50; 0.02 without `count`.
        `bracket`: width of the bracket of a threshold over its lower end. `refined`: realisations that are also shot on the converged mesh,
        which corrects V50: 1 where nothing varies and 4 otherwise; 0 leaves V50 to the mesh of the case. `options`: see `ripstop.studies.study`.
        """
        within("refined", refined, 0, 1_000_000)
        usual = 4 if self.handle.varies else 1
        request = _limit(count, until_width, bracket) | {"refined": usual if refined is None else refined}
        return studies.study(studies.V50, self.handle, request, **options)

    def sweep(
        self, over: Mapping[str, Iterable[Any]], *, run: Literal["shots", "v50"] = "shots", count: int | None = None,
        until_width: float | None = None, bracket: float = 0.005, **options: Unpack[studies.Options],
    ) -> studies.Sweep:  # fmt: skip
        """Shots or a V50 at every point of a grid, as `ripstop sweep`.

        `over`: values by JSON pointer, `{"/pack/plies": [1, 2, 4]}`. `count`: shots at each point, 1 without, or realisations of a V50.
        `until_width`, `bracket`: as of `v50`. `options`: see `ripstop.studies.study`.
        """
        among("run", run, ("shots", "v50"))
        factors = [(pointer, [json.dumps(value, default=plain) for value in values]) for pointer, values in over.items()]
        if not factors or not all(values for _, values in factors):
            raise refusal("over", "values by JSON pointer", "none", "such as {'/pack/plies': [1, 2, 4]}")
        request = _limit(count, until_width, bracket) if run == "v50" else {"count": 1 if count is None else count}
        within("count", request["count"], 1, 1_000_000)
        return studies.study(studies.Sweep, self.handle, request | {"over": factors}, **options)


def _limit(count: int | None, until_width: float | None, bracket: float) -> dict[str, Any]:
    """Request of a V50, with what the command takes where nothing is said."""
    within("count", count, 1, 1_000_000)
    within("until_width", until_width, 1e-6, 1.0)
    within("bracket", bracket, 1e-6, 1.0)
    width = 0.02 if until_width is None and count is None else until_width
    return {"v50": True, "count": 64 if count is None else count, "until_width": width, "bracket": bracket}


def _restored(*parts: Any) -> Case:
    return Case._of(_ripstop.Case.parse(*parts))
