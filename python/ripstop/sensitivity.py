"""Sensitivity of an output of a case to its parameters, by SALib: Sobol indices, or Morris screening.

The shots are a campaign: they lie in a folder, and the same call goes on with what lies there.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from .campaign import OUTPUTS, Campaign, Compute, Plan, campaign

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
#: Bounds, a list of choices, or a distribution of SALib: `{"dist": "norm", "bounds": [mean, standard deviation]}`.
Factor = tuple[float, float] | list[Any] | Mapping[str, Any]
#: Resamples of the rows for the intervals.
RESAMPLES = 1000


@dataclass
class Study:
    """Indices of each factor with intervals, and the points they come from."""

    output: str
    method: str
    level: float
    #: Index by factor, each with its ends at the two-sided confidence `level`. Sobol: `S1` (alone) and `ST` (with others), parts of the variance.
    #: Morris: `mu_star` (mean absolute effect over the range) and `sigma` (scatter of effects), in the unit of the output.
    indices: dict[str, dict[str, tuple[float, float, float]]]
    #: Values of the factors by point, the output, and its own standard error, shape (points); NaN where a point failed.
    points: list[dict[str, Any]] = field(repr=False)
    values: Array = field(repr=False)
    errors: Array = field(repr=False)
    #: Reasons of the points without a value, and how many have each.
    failed: dict[str, int]
    #: Part of the variance of the output that is its own uncertainty: smaller indices are none.
    noise: float
    campaign: Campaign

    def to_pandas(self) -> pandas.DataFrame:
        """Table of the indices."""
        import pandas
        rows = [{f"{name}{end}": ends[k] for name, ends in row.items() for k, end in enumerate(("", "_low", "_high"))} for row in self.indices.values()]
        return pandas.DataFrame(rows, index=list(self.indices))

    @property
    def notes(self) -> list[str]:
        """Sentences on what failed, and on how far the indices go."""
        lost = sum(self.failed.values())
        notes = [f"{lost} of {len(self.points)} points have no result; the indices leave them out."] if lost else []
        notes += [f"{count} times: {reason}" for reason, count in self.failed.items()]
        return [*notes, f"The uncertainty of the output itself makes up {self.noise:.1%} of its variance. Smaller indices are none."]

    def _repr_html_(self) -> str:
        return str(self.to_pandas().to_html(float_format="%.3g")) + "".join(f"<p>{note}</p>" for note in self.notes)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the indices with their intervals, the largest on top."""
        import matplotlib.pyplot as plt
        ax = ax or plt.subplots(figsize=(7, 0.5 + 0.5 * len(self.indices)))[1]
        last = list(next(iter(self.indices.values())))[1 if self.method == "sobol" else 0]
        names = sorted(self.indices, key=lambda name: self.indices[name][last][0])
        for k, index in enumerate(next(iter(self.indices.values()))):
            value, low, high = np.array([self.indices[name][index] for name in names]).T
            ax.errorbar(value, np.arange(len(names)) + 0.15 * (k - 0.5), xerr=[np.maximum(value - low, 0), np.maximum(high - value, 0)], fmt="o", label=index)
        ax.set_yticks(range(len(names)), [_short(name) for name in names])
        ax.set_xlabel(f"index of {self.output}" + (", parts of its variance" if self.method == "sobol" else ""))
        ax.axvline(0, color="grey", lw=0.5)
        ax.legend()
        return ax


def study(
    case: Any, factors: Mapping[str, Factor], output: str = "v50", *, method: Literal["sobol", "morris"] = "sobol", samples: int = 64, seed: int = 1,
    level: float = 0.9, folder: str | Path | None = None, cluster: Any = None, progress: bool | None = None, compute: Compute | None = None,
    **options: Any,
) -> Study:  # fmt: skip
    """Find which factors an output depends on.

    `factors`: by JSON pointer, or by several with a space between that take the same value: bounds, a list of choices, or a distribution of
    SALib. `output`: `v50`, or a number of the summary of a run, such as `absorbed_energy_j`. `samples`: of Sobol, a power of 2, for
    `samples` × (factors + 2) points; of Morris, trajectories of (factors + 1) points. `seed`: of the points. `folder`, `cluster`, `progress`,
    `compute`: as of `campaign`; the folder is by default `out/NAME-study`. `options`: of `Case.v50` or `Case.run`.

    All points have the draws of one seed, so most of the scatter of V50 is the same in all. The intervals do not count on it: in each resample
    of the rows every V50 has an error of its own, drawn from its sampling interval and its bracket. Errors: `ValueError`.
    """
    document, name = (case, "case") if isinstance(case, Mapping) else (case.document, case.name)
    problem = _problem(factors)
    if output != "v50" and output in OUTPUTS["v50"]:
        raise ValueError(f"study, output: expected v50 or a number of a run, found {output!r}")
    run = "v50" if output == "v50" else "run"
    if method == "morris" and any(isinstance(factor, Mapping) for factor in factors.values()):
        raise ValueError("study, morris: expected bounds or choices, for its points lie on the ends of the range; found a distribution")
    # A V50 that corrects itself on a finer mesh costs three times as much, and shifts all points alike.
    usual, outputs = ({"refined": 0, "bracket": 0.01}, OUTPUTS["v50"]) if run == "v50" else ({}, [output])
    plan = Plan(document, _choose(factors, _sample(problem, method, samples, seed)), run, {**usual, **options}, outputs)
    done = campaign(plan, folder or Path("out", f"{name}-study"), cluster, progress=progress, compute=compute)
    values, errors, failed = _read(done, plan, output)
    unit = _sample({**problem, "bounds": [[0, 1]] * len(factors), "dists": ["unif"] * len(factors)}, method, samples, seed)
    rng = np.random.default_rng(seed)
    indices = _sobol if method == "sobol" else _morris
    if not np.isfinite(values).any():
        raise ValueError(f"study: no point has a result: {'; '.join(failed)}")
    best = indices(values, unit, None, 0.0)
    noise = float(np.nanmean(errors**2))
    draws = [indices(values + rng.normal(0, 1, values.size) * np.nan_to_num(errors), unit, rng, noise) for _ in range(RESAMPLES)]
    ends = {name: np.nanquantile([draw[name] for draw in draws], [(1 - level) / 2, (1 + level) / 2], axis=0) for name in best}
    found = {
        factor: {name: (float(best[name][k]), float(ends[name][0][k]), float(ends[name][1][k])) for name in best}
        for k, factor in enumerate(factors)
    }
    variance = float(np.nanvar(values))
    return Study(output, method, level, found, list(plan), values, errors, failed, noise / variance if variance else math.nan, done)


def _problem(factors: Mapping[str, Factor]) -> dict[str, Any]:
    """Problem as SALib describes it; a list of choices is a number from 0 to their count."""
    bounds, dists = [], []
    for name, factor in factors.items():
        if isinstance(factor, Mapping):
            bounds.append(list(factor["bounds"]))
            dists.append(str(factor["dist"]))
        else:
            bounds.append([0, len(factor)] if isinstance(factor, list) else [float(end) for end in factor])
            dists.append("unif")
        if len(bounds[-1]) < 2 or (dists[-1] == "unif" and not bounds[-1][0] < bounds[-1][1]):
            raise ValueError(f"study, {name}: expected bounds, the lower one first, a list of choices or a distribution, found {factor!r}")
    if not factors:
        raise ValueError("study: expected at least one factor")
    return {"num_vars": len(factors), "names": list(factors), "bounds": bounds, "dists": dists}


def _sample(problem: dict[str, Any], method: str, samples: int, seed: int) -> Array:
    """Points, shape (points, factors)."""
    if method == "sobol":
        if samples < 2 or samples & (samples - 1):
            raise ValueError(f"study, samples: expected a power of 2 from 2 on, found {samples}")
        from SALib.sample import sobol
        return np.asarray(sobol.sample(problem, samples, calc_second_order=False, seed=seed))
    if method == "morris":
        from SALib.sample import morris
        return np.asarray(morris.sample(problem, samples, seed=seed))
    raise ValueError(f"study, method: expected sobol or morris, found {method!r}")


def _choose(factors: Mapping[str, Factor], points: Array) -> dict[str, list[Any]]:
    """Columns of values by factor."""
    return {
        name: [factor[min(int(x), len(factor) - 1)] for x in column] if isinstance(factor, list) else [float(x) for x in column]
        for (name, factor), column in zip(factors.items(), points.T, strict=True)
    }


def _read(done: Campaign, plan: Plan, output: str) -> tuple[Array, Array, dict[str, int]]:
    """Values, their standard errors, and the reasons of those that failed."""
    from scipy.stats import norm
    rows = done.read()
    failed = Counter(row["reason"] for row in rows if row["reason"])
    if output != "v50":
        texts = [row[output] for row in rows]
        values = np.array([float(text) if text else math.nan for text in texts])
        return values, np.zeros(values.size), dict(failed)
    numbers = {name: np.array([float(row[name] or "nan") for row in rows]) for name in OUTPUTS["v50"]}
    # Halves of intervals: of the sampling interval at its level, of a bracket, in which a threshold lies anywhere.
    scale = norm.ppf(0.5 + 0.5 * np.nan_to_num(numbers["level"], nan=0.9))
    sampling = np.nan_to_num(numbers["half_width_m_s/sampling"]) / scale
    return numbers["v50_m_s"], np.hypot(sampling, np.nan_to_num(numbers["half_width_m_s/bracket"]) / math.sqrt(3)), dict(failed)


def _sobol(values: Array, unit: Array, rng: np.random.Generator | None, noise: float) -> dict[str, Array]:
    """First-order and total indices by SALib's estimators (Saltelli 2010, Jansen), of rows drawn anew where there is a generator.

    A point that failed costs the rows of the factors it belongs to. `noise`: variance that was added to the values, and is taken out again.
    """
    from SALib.analyze.sobol import first_order, separate_output_values, total_order
    count = unit.shape[1]
    a, b, ab, _ = separate_output_values(values - np.nanmean(values), count, values.size // (count + 2), False)
    found = []
    for k in range(count):
        keep = np.flatnonzero(np.isfinite(a) & np.isfinite(b) & np.isfinite(ab[:, k]))
        rows = keep if rng is None else rng.choice(keep, keep.size)
        parts = (a[rows], ab[rows, k], b[rows])
        variance = float(np.var(np.r_[parts[0], parts[2]])) if rows.size > 1 else 0.0
        if variance <= noise:
            found.append((math.nan, math.nan) if variance else (0.0, 0.0))
            continue
        scale = variance / (variance - noise)
        found.append((float(first_order(*parts)) * scale, (float(total_order(*parts)) - noise / variance) * scale))
    return dict(zip(("S1", "ST"), np.array(found).T, strict=True))


def _morris(values: Array, unit: Array, rng: np.random.Generator | None, noise: float) -> dict[str, Array]:
    """Mean absolute effect and scatter of effects by SALib, over the range of a factor; a trajectory with a failed point is left out."""
    from SALib.analyze import morris
    length = unit.shape[1] + 1
    paths = values.reshape(-1, length)
    keep = np.flatnonzero(np.isfinite(paths).all(axis=1))
    if keep.size < 2:
        raise ValueError(f"study: {keep.size} of {len(paths)} trajectories have all their results, and two are needed")
    rows = keep if rng is None else rng.choice(keep, keep.size)
    problem = {"num_vars": length - 1, "names": [str(k) for k in range(length - 1)], "bounds": [[0, 1]] * (length - 1)}
    x = unit.reshape(-1, length, length - 1)[rows].reshape(-1, length - 1)
    found = morris.analyze(problem, x, paths[rows].ravel(), num_resamples=2)
    return {"mu_star": np.asarray(found["mu_star"], float), "sigma": np.asarray(found["sigma"], float)}


def _short(name: str) -> str:
    """Last part of a pointer, with that before it."""
    return "/".join(name.split()[0].strip("/").split("/")[-2:]) + (" …" if " " in name else "")
