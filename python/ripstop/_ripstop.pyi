"""The library, in Rust. `ripstop` makes it pleasant."""

from collections.abc import Callable, Mapping
from os import PathLike
from typing import Any

__version__: str

Show = Callable[[Mapping[str, float | None]], object]
Frames = tuple[list[tuple[int, int, int, int]], bytes, list[tuple[float, dict[str, bytes], list[float] | None]]]

class CaseError(ValueError):
    """Refusal of a case, of an argument, or of a file or folder: where, expected, found, help."""

class RunError(RuntimeError):
    """A run or study without a result; `result` holds what there is of it, or None."""

    result: Any

class DeviceError(RunError):
    """No graphics device for what was asked, or one that was lost on the way."""

class Case:
    """A checked case."""

    title: str
    name: str
    varies: bool
    @staticmethod
    def read(path: str) -> Case: ...
    @staticmethod
    def parse(name: str, text: str, path: str, sets: list[str]) -> Case: ...
    def with_sets(self, sets: list[str]) -> Case: ...
    def parts(self) -> tuple[str, str, str, list[str]]: ...
    def check(self) -> str: ...
    def json(self) -> str: ...

class Run:
    """A run that has ended."""

    def summary(self) -> str: ...
    def verdict(self) -> str: ...
    def history(self) -> tuple[list[str], bytes]: ...
    def table(self, name: str) -> str: ...
    def frames(self) -> Frames | None: ...
    def page(self) -> str: ...

def schema() -> str: ...
def run(
    case: Case,
    backend: str,
    adapter: str | None,
    precision: str | None,
    threads: int | None,
    frames: int | None,
    out: str | None,
    show: Show | None,
) -> tuple[Run, BaseException | None]: ...
def study(
    case: Case,
    request: str,
    out: PathLike[str],
    backend: str,
    adapter: str | None,
    precision: str | None,
    threads: int | None,
    show: Show | None,
) -> tuple[str | None, BaseException | None, bool]: ...
def crossover(case: Case, warp: list[float], weft: list[float], law: str | None) -> tuple[list[str], bytes]: ...
def fit(
    data: str, name: str | None, unit: str | None, columns: list[tuple[str, str]], spread: float | None, level: float
) -> tuple[str, str]: ...
