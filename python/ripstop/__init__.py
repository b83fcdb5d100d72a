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
from .campaign import Plan, campaign
from .case import Case
from .messages import CaseError, DeviceError, Interrupted, RunError
from .plot import overlay
from .results import Frame, Run, Table
from .studies import V50, Fit, Shots, Sweep, crossover, fit

if TYPE_CHECKING:
    from .calibration import Limit, PictureFrame, ResidualVelocities, TensionTest, calibrate
    from .sensitivity import study

#: Names whose modules are imported when they are asked for, for they import larger libraries.
LATER = {"study": "sensitivity"}
LATER |= dict.fromkeys(["Limit", "PictureFrame", "ResidualVelocities", "TensionTest", "calibrate"], "calibration")

__all__ = [
    "Case", "CaseError", "DeviceError", "Fit", "Frame", "Interrupted", "Plan", "Run", "RunError", "Shots", "Sweep", "Table", "V50",
    "__version__", "campaign", "crossover", "fit", "overlay", *LATER,
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in LATER:
        raise AttributeError(f"module 'ripstop' has no attribute {name!r}")
    # Also where a module has the same name: the function takes its place.
    value = globals()[name] = getattr(import_module(f".{LATER[name]}", __name__), name)
    return value
