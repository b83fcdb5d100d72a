"""ripstop: what happens when a projectile strikes woven fabric.

>>> import ripstop
>>> case = ripstop.Case("cases/s720-1ply-155.json")
>>> run = case.with_({"/projectile/velocity_m_s": 250}).run()
>>> run.outcome, run.residual_velocity_m_s
>>> case.v50().plot()
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from ._ripstop import __version__
from .case import Case
from .errors import CaseError, DeviceError, Interrupted, RunError
from .frames import Frame, Frames
from .run import Run
from .studies import V50, Fit, Shots, Sweep, crossover, fit
from .table import Table

if TYPE_CHECKING:
    from .plot import overlay as overlay

#: Names whose modules are imported when they are asked for, for they import larger libraries.
LATER = {"overlay": "plot"}

__all__ = [
    "Case",
    "CaseError",
    "DeviceError",
    "Fit",
    "Frame",
    "Frames",
    "Interrupted",
    "Run",
    "RunError",
    "Shots",
    "Sweep",
    "Table",
    "V50",
    "__version__",
    "crossover",
    "fit",
    *LATER,
]


def __getattr__(name: str) -> Any:
    if name not in LATER:
        raise AttributeError(f"module 'ripstop' has no attribute {name!r}")
    # Also where a module has the same name: the function takes its place.
    value = globals()[name] = getattr(import_module(f".{LATER[name]}", __name__), name)
    return value
