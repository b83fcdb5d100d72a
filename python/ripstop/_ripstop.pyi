"""The library, in Rust. `ripstop` makes it pleasant."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, final

__all__ = ["Case", "CaseError", "DeviceError", "Run", "RunError", "__version__", "crossover", "fit", "run", "schema", "study"]
__version__: str

_Show = Callable[[Mapping[str, float | None]], object]
_Frames = tuple[list[tuple[int, int, int]], bytes, list[tuple[float, dict[str, bytes], list[float] | None]]]

class CaseError(ValueError):
    """Refusal of a case, of an argument, or of a file or folder: where, expected, found, help; `result` of one that comes after a run."""

    result: Any

class RunError(RuntimeError):
    """A run or study without a result; `result` holds what there is of it, or None."""

    result: Any

class DeviceError(RunError):
    """No graphics device for what was asked, or one that was lost on the way."""

@final
class Case:
    """A checked case."""

    title: str
    name: str
    varies: bool
    @staticmethod
    def read(path: str) -> Case: ...
    @staticmethod
    def parse(name: str, text: str, path: str | Path, sets: list[str]) -> Case: ...
    def with_sets(self, sets: list[str]) -> Case: ...
    def parts(self) -> tuple[str, str, Path, list[str]]: ...
    def check(self) -> str: ...
    def json(self) -> str: ...

@final
class Run:
    """A run that has ended."""

    def summary(self) -> str: ...
    def verdict(self) -> str: ...
    def history(self) -> tuple[list[str], bytes]: ...
    def table(self, name: str) -> str: ...
    def frames(self) -> _Frames | None: ...
    def page(self) -> str: ...

def schema() -> str: ...
def run(case: Case, request: str, show: _Show | None) -> tuple[Run, BaseException | None]: ...
def study(case: Case, request: str, show: _Show | None) -> tuple[str | None, BaseException | None]: ...
def crossover(case: Case, warp: list[float], weft: list[float], law: str | None) -> tuple[list[str], bytes]: ...
def fit(
    data: str, name: str, unit: str | None, columns: list[tuple[str, str]], spread: float | None, level: float
) -> tuple[str, str]: ...
