"""Plots with matplotlib, which is imported when the first is drawn. Every function draws on `ax`, or on a new figure, and returns the axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import NormalDist
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .results import Run
    from .studies import V50, Fit, Shots, Sweep

#: Colours of shots that were stopped and that perforated, which the colour-blind tell apart.
COLOURS = {"stopped": "#0072b2", "perforated": "#d55e00"}

#: Energies at a time, by their columns.
ENERGIES = {
    "projectile_energy_j": "projectile", "kinetic_energy_j": "fabric, kinetic", "stored_energy_j": "fabric, elastic",
    "failure_energy_j": "yarn failure", "friction_j": "friction", "contact_dissipation_j": "contact",
    "viscous_dissipation_j": "shock viscosity", "hourglass_energy_j": "hourglass", "backing_energy_j": "clay",
}  # fmt: skip

#: Ends of names that are a unit.
UNITS = {"_m_s": "m/s", "_us": "µs", "_mm": "mm", "_n": "N", "_j": "J", "_gpa": "GPa", "_mpa": "MPa", "_deg": "°", "_g": "g"}


def words(name: str) -> str:
    """Name of a column in words, with its unit."""
    name = name.rsplit("/", 1)[-1]
    end = max(filter(name.endswith, UNITS), key=len, default="")
    return name.removesuffix(end).replace("_", " ") + (f" [{UNITS[end]}]" if end else "")


def axes(ax: Axes | None, across: str, up: str) -> Axes:
    """These axes or new ones, with labels."""
    if ax is None:
        import matplotlib.pyplot as plt

        ax = plt.subplots(layout="constrained")[1]
    ax.set(xlabel=across, ylabel=up)
    ax.grid(alpha=0.3)
    return ax


def overlay(
    runs: Mapping[str, Run] | Sequence[Run], column: str = "projectile_velocity_m_s",
    measured: Mapping[str, Any] | None = None, ax: Axes | None = None,
) -> Axes:  # fmt: skip
    """Draws a column of the history of runs over time [µs] in one figure.

    `runs`: by their labels, or in a row, labelled by their titles. `measured`: columns `time_us` and the one drawn, a dict or a DataFrame.
    """
    ax = axes(ax, words("time_us"), words(column))
    named = runs.items() if isinstance(runs, Mapping) else [(run.title, run) for run in runs]
    for label, run in named:
        ax.plot(run.history["time_us"], run.history[column], label=label)
    if measured is not None:
        ax.plot(measured["time_us"], measured[column], "k.", label="measured")
    if len(ax.lines) > 1:
        ax.legend()
    return ax


def velocity(run: Run, ax: Axes | None = None) -> Axes:
    """Draws the projectile's velocity [m/s] over time [µs]."""
    return overlay([run], ax=ax)


def force(run: Run, ax: Axes | None = None) -> Axes:
    """Draws the contact force [N] over time [µs]."""
    return overlay([run], "contact_force_n", ax=ax)


def energies(run: Run, ax: Axes | None = None) -> Axes:
    """Draws the energies of a run [J] over time [µs]; those below 0.5 % of the largest are left out."""
    ax = axes(ax, words("time_us"), "energy [J]")
    largest = {column: np.abs(run.history[column]).max(initial=0.0) for column in ENERGIES}
    for column, name in ENERGIES.items():
        if largest[column] > 0.005 * max(largest.values()):
            ax.plot(run.history["time_us"], run.history[column], label=name)
    ax.legend()
    return ax


def residual(shots: Shots | V50, ax: Axes | None = None) -> Axes:
    """Draws residual over impact velocity [m/s], Vs-Vr, with the fitted curves Vr = a (Vs^p - V0^p)^(1/p)."""
    ax = axes(ax, "impact velocity [m/s]", "residual velocity [m/s]")
    impact, passed = shots.table["velocity_m_s"], shots.table["outcome"] == "perforated"
    stopped = np.isin(shots.table["outcome"], ["stopped", "rebounded"])
    ax.plot(impact[stopped], 0.0 * impact[stopped], "o", color=COLOURS["stopped"], fillstyle="none", label="stopped")
    ax.plot(impact[passed], shots.table["residual_velocity_m_s"][passed], "o", color=COLOURS["perforated"], label="perforated")
    for curve in shots.residual:
        if (v0 := curve["limit"]) is not None:
            fast = np.linspace(v0, max(impact.max(), v0), 200)
            left = curve["a"] * (fast ** curve["p"] - v0 ** curve["p"]) ** (1 / curve["p"])
            ax.plot(fast, left, label=f"{curve['curve']}, limit {v0:.4g} m/s")
    ax.legend()
    return ax


def limit(found: V50 | Shots | Fit, ax: Axes | None = None) -> Axes:
    """Draws the chance of a perforation over velocity, from V0 to V100, with the intervals of its quantiles, and the shots at 0 and 1.

    Where nothing varies it is a step; without a limit there are the shots alone.
    """
    summary, unit = found.summary, found.summary.get("unit", "m/s")
    ax = axes(ax, f"impact velocity [{unit}]", "chance of a perforation")
    mean, sigma = (summary.get(ours, summary.get(fitted)) for ours, fitted in (("v50_m_s", "mu"), ("sigma_m_s", "sigma")))
    if mean is not None and sigma:
        normal = NormalDist(mean, sigma)
        fast = np.linspace(mean - 4 * sigma, mean + 4 * sigma, 200)
        ax.plot(fast, [normal.cdf(at) for at in fast], "k", label=f"V50 {mean:.4g} {unit}, σ {sigma:.3g} {unit}")
    elif mean is not None:
        ax.axvline(mean, color="k", label=f"limit {mean:.4g} {unit}")
    ends = [(one["p"], one["low"], one["high"]) for one in summary["quantiles"] if None not in (one["low"], one["high"])]
    if ends:
        ax.hlines(*zip(*ends), color="grey", label=f"{summary['level']:.0%} interval" if summary["level"] else "interval")
    if {"velocity_m_s", "outcome"} <= found.table.keys():
        for place, (outcome, colour) in enumerate(COLOURS.items()):
            shot = found.table["velocity_m_s"][found.table["outcome"] == outcome]
            ax.plot(shot, np.full(len(shot), place), "|", color=colour, label=outcome)
    elif {"velocity_m_s", "perforated"} <= found.table.keys():
        ax.plot(found.table["velocity_m_s"], found.table["perforated"], "|", label="shots")
    ax.set_ylim(-0.05, 1.05)
    ax.legend()
    return ax


def sweep(found: Sweep, ax: Axes | None = None) -> Axes:
    """Draws the response of a sweep over its first factor, a line for each combination of the others."""
    first, *others = [name for name in found.table if name.startswith("/")]
    ax = axes(ax, words(first), words(found.response))
    groups = list(zip(*(found.table[name] for name in others))) or [()] * len(found.table[first])
    for group in dict.fromkeys(groups):
        one = np.array([other == group for other in groups])
        label = ", ".join(f"{words(name)}: {value}" for name, value in zip(others, group))
        ax.plot(found.table[first][one], found.table[found.response][one], "o-", label=label)
    if others:
        ax.legend()
    return ax
