"""Calibration of what is assumed in a case, to measurements with stated errors.

Errors are independent and normal, so the likelihood is a sum of squares. An interval of a parameter is that of the profile likelihood: all values
that fit, with all others fitted anew, no worse than the best by the chi-square of one degree of freedom (Venzon and Moolgavkar 1988).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    import pandas

Array = NDArray[np.float64]


class Measurement(Protocol):
    """What was measured: `observed` values and standard errors, what to `predict` for a case, with the model's own errors, and its `step`.

    `step`: of differences, over the range of a parameter; long against the scatter of the model.
    """

    step: float

    def observed(self) -> tuple[Array, Array]: ...
    def predict(self, case: Any) -> tuple[Array, Array]: ...


@dataclass(frozen=True)
class TensionTest:
    """Strip of fabric drawn along its warp or weft.

    `stretch`: length over length at rest [-]. `tension_n`: force over the number of yarns drawn [N]. `error_n`: its standard error, one or one for
    each point. `across`: whether the other yarns are `free` at the edges of the strip, or `held` at their length. `breaking_n`: force of a yarn at
    which the strip broke [N], and its standard error; it fixes `failure_strain`. The law is that of the unit cell.
    """

    stretch: ArrayLike
    tension_n: ArrayLike
    error_n: ArrayLike
    along: Literal["warp", "weft"] = "warp"
    across: Literal["free", "held"] = "free"
    breaking_n: tuple[float, float] | None = None
    step: float = 1e-4

    def observed(self) -> tuple[Array, Array]:
        (values, errors), (force, error) = _pair(self.tension_n, self.error_n), self.breaking_n or ([], [])
        return np.r_[values, force], np.r_[errors, error]

    def predict(self, case: Any) -> tuple[Array, Array]:
        stretch = np.asarray(self.stretch, float)
        tension = self._curve(case, stretch)[0]
        if self.breaking_n is not None:
            yarn = case.document["fabric"][self.along]
            strain = yarn.get("failure_strain")
            if strain is None:
                raise ValueError(f"TensionTest: a breaking force needs /fabric/{self.along}/failure_strain in the case, not a strength")
            strain *= yarn.get("strength_retention", 1.0)
            forces, strains = self._curve(case, np.linspace(1, 1.05 * (1 + strain) * (1 + yarn.get("crimp", 0.2)), 100))
            tension = np.r_[tension, np.interp(strain, strains, forces)]
        return tension, np.zeros(tension.size)

    def _curve(self, case: Any, stretch: Array) -> tuple[Array, Array]:
        import ripstop
        # Free yarns shorten until they carry nothing: any stretch below what the weave can reach is the same.
        other = {"held": 1.0, "free": 0.5}[self.across]
        along = (stretch.tolist(), other) if self.along == "warp" else (other, stretch.tolist())
        cell = ripstop.crossover(case, *along)
        return np.asarray(cell[f"{self.along}_tension_n"], float), np.asarray(cell[f"{self.along}_strain"], float)


@dataclass(frozen=True)
class PictureFrame:
    """Square of fabric sheared in a frame of four hinged bars.

    `angle_rad`: shear angle [rad]. `force_n`: force along the diagonal [N], `error_n` its standard error. `side_mm`: side of the frame. The law is
    (25) of the paper, G the slope of the stress, with F = L t tau / sin(pi/4 - angle/2).
    """

    angle_rad: ArrayLike
    force_n: ArrayLike
    error_n: ArrayLike
    side_mm: float
    step: float = 1e-4

    def observed(self) -> tuple[Array, Array]:
        return _pair(self.force_n, self.error_n)

    def predict(self, case: Any) -> tuple[Array, Array]:
        fabric = case.document["fabric"]
        keys = {"thickness_mm": fabric.get("thickness_mm", 0.3), "g1_mpa": 10, "g2_mpa": 1000, "gamma1": 0.35, "gamma2": 0.6}
        shear = keys | (fabric.get("shear") or {})
        angle = np.asarray(self.angle_rad, float)
        ramp = shear["gamma2"] - shear["gamma1"]
        into, past = np.clip(angle - shear["gamma1"], 0, ramp), np.maximum(angle - shear["gamma2"], 0)
        more = np.divide(into**2, 2 * ramp, out=np.zeros_like(into), where=ramp > 0) + past
        stress = shear["g1_mpa"] * angle + (shear["g2_mpa"] - shear["g1_mpa"]) * more
        force = self.side_mm * shear["thickness_mm"] * stress / np.sin(math.pi / 4 - angle / 2)  # mm² · MPa = N
        return force, np.zeros(force.size)


@dataclass(frozen=True)
class ResidualVelocities:
    """Shots above the limit: `velocity_m_s`, `residual_velocity_m_s` and its standard error `error_m_s` [m/s]; `options` of `Case.run`."""

    velocity_m_s: ArrayLike
    residual_velocity_m_s: ArrayLike
    error_m_s: ArrayLike
    options: Mapping[str, Any] = field(default_factory=dict)
    step: float = 0.05

    def observed(self) -> tuple[Array, Array]:
        return _pair(self.residual_velocity_m_s, self.error_m_s)

    def predict(self, case: Any) -> tuple[Array, Array]:
        def shoot(velocity: float) -> tuple[float, float]:
            run = case.with_({"/projectile/velocity_m_s": velocity}).run(**{"backend": "cpu", "progress": False, **self.options})
            return run.residual_velocity_m_s, run.summary.get("residual_velocity_scatter_m_s") or 0.0

        pairs = np.array([shoot(float(velocity)) for velocity in np.atleast_1d(np.asarray(self.velocity_m_s, float))])
        return pairs[:, 0], pairs[:, 1]


@dataclass(frozen=True)
class Limit:
    """V50 and its standard error [m/s]; `options` of `Case.v50`. The interval of the computed one counts as an error of the model."""

    v50_m_s: float
    error_m_s: float
    options: Mapping[str, Any] = field(default_factory=dict)
    step: float = 0.05

    def observed(self) -> tuple[Array, Array]:
        return _pair(self.v50_m_s, self.error_m_s)

    def predict(self, case: Any) -> tuple[Array, Array]:
        found = case.v50(**{"refined": 0, "progress": False, **self.options})
        # Half an interval of 90 % is 1.645 standard errors of a normal distribution.
        width = math.hypot(*(part or 0.0 for part in found.summary["half_width_m_s"].values())) / 1.645
        return np.array([found.v50_m_s]), np.array([width])


@dataclass
class Calibration:
    """Best parameters, their intervals, and what the data cannot fix."""

    #: Best value, lower and upper end by parameter, at the two-sided confidence `level`; `None`: the interval reaches the bound.
    parameters: dict[str, tuple[float, float | None, float | None]]
    level: float
    #: Sum of squares over the stated errors, degrees of freedom, and chance of a larger sum if model and errors hold.
    chi_square: float
    freedom: int
    p_value: float | None
    #: What the data cannot fix, and whether the model describes them; sentences.
    notes: list[str]
    #: The case with the best parameters; values and rises of the sum of squares by parameter; number of cases computed.
    case: Any = field(repr=False)
    profiles: dict[str, list[tuple[float, float]]] = field(repr=False)
    evaluations: int

    def to_pandas(self) -> pandas.DataFrame:
        """Table of the parameters."""
        import pandas
        return pandas.DataFrame.from_dict(self.parameters, orient="index", columns=["value", "low", "high"])

    def _repr_html_(self) -> str:
        return str(self.to_pandas().to_html()) + "".join(f"<p>{note}</p>" for note in self.notes)


def calibrate(case: Any, parameters: Mapping[str, tuple[float, float]], data: Sequence[Measurement], level: float = 0.9) -> Calibration:
    """Fit parameters of a case to measurements.

    `parameters`: bounds by JSON pointer, or by several with a space between that take the same value. `data`: measurements, all at once.
    `level`: two-sided confidence. The search begins in the middle of the bounds.
    Errors: `ValueError` for bounds and errors that are none, and those of the case.
    """
    from scipy.stats import chi2
    fit = _Fit(case, parameters, data)
    best = fit.minimise(np.full(len(fit.names), 0.5), {})
    threshold = float(chi2.ppf(level, 1))
    profiles, ends, better = fit.profiles(best, threshold)
    while better is not None:  # again where a profile finds a better fit
        best = fit.minimise(better, {})
        profiles, ends, better = fit.profiles(best, threshold)
    scale = fit.high - fit.low
    sides = [[None if end is None else float(fit.low[k] + end * scale[k]) for end in ends[k]] for k in range(len(ends))]
    found = {name: (float(fit.low[k] + best[k] * scale[k]), sides[k][0], sides[k][1]) for k, name in enumerate(fit.names)}
    least, freedom = fit.chi_square(best), fit.count - len(found)
    p_value = float(chi2.sf(least, freedom)) if freedom > 0 else None
    notes = [_open(name, sides[k], (fit.low[k], fit.high[k])) for k, name in enumerate(fit.names)] + fit.loose(best)
    if p_value is None:
        notes.append("There are no more data than parameters: whether the model holds cannot be tested.")
    elif p_value < 0.01:
        notes.append(f"The model does not describe the data within their errors: chi-square {least:.3g} with {freedom} degrees of freedom.")
    calibrated = case.with_(fit.changes(best))
    profile = {name: [(float(fit.low[k] + u * scale[k]), rise) for u, rise in profiles[k]] for k, name in enumerate(fit.names)}
    return Calibration(found, level, least, freedom, p_value, [note for note in notes if note], calibrated, profile, len(fit.known))


class _Fit:
    """Sum of squares over parameters between 0 and 1."""

    def __init__(self, case: Any, parameters: Mapping[str, tuple[float, float]], data: Sequence[Measurement]) -> None:
        self.case, self.names, self.data = case, list(parameters), list(data)
        for name, (low, high) in parameters.items():
            if not (math.isfinite(low) and low < high < math.inf):
                raise ValueError(f"calibrate, {name}: expected finite bounds, the lower one first, found {(low, high)}")
        if not self.names or not self.data:
            raise ValueError("calibrate: expected at least one parameter and one measurement")
        self.low, self.high = np.array(list(parameters.values()), float).T
        self.step = max(measurement.step for measurement in data)
        self.count = sum(measurement.observed()[0].size for measurement in data)
        self.known: dict[bytes, Array] = {}

    def changes(self, unit: Array) -> dict[str, float]:
        values = (self.low + unit * (self.high - self.low)).tolist()
        return {pointer: value for name, value in zip(self.names, values, strict=True) for pointer in name.split()}

    def residuals(self, unit: Array) -> Array:
        """Differences over their errors, shape (data)."""
        key = unit.tobytes()
        if key not in self.known:
            case = self.case.with_(self.changes(unit))
            parts = []
            for measurement in self.data:
                (observed, error), (predicted, own) = measurement.observed(), measurement.predict(case)
                parts.append((predicted - observed) / np.hypot(error, own))
            self.known[key] = np.concatenate(parts)
        return self.known[key]

    def chi_square(self, unit: Array) -> float:
        return float(np.sum(self.residuals(unit) ** 2))

    def minimise(self, start: Array, fixed: Mapping[int, float]) -> Array:
        """Best parameters from a start, some of them fixed."""
        from scipy.optimize import least_squares
        unit, free = start.copy(), [k for k in range(start.size) if k not in fixed]
        unit[list(fixed)] = list(fixed.values())
        if not free:
            return unit
        def part(shifted: Array) -> Array:
            trial = unit.copy()
            trial[free] = shifted - 1
            return self.residuals(trial)

        # diff_step is relative: the values are shifted to lie between 1 and 2.
        found = least_squares(
            part, np.clip(unit[free], 1e-6, 1 - 1e-6) + 1, bounds=(1, 2), diff_step=self.step, x_scale=1.0,
            xtol=0.01 * self.step, ftol=1e-6, gtol=1e-10, max_nfev=60,
        )  # fmt: skip
        unit[free] = np.clip(found.x - 1, 0, 1)
        return unit

    def jacobian(self, unit: Array) -> Array:
        """Derivatives of residuals, shape (data, parameters), by central differences inside the bounds."""
        columns = []
        for k in range(unit.size):
            ends = [unit.copy(), unit.copy()]
            ends[0][k], ends[1][k] = max(0.0, unit[k] - self.step), min(1.0, unit[k] + self.step)
            columns.append((self.residuals(ends[1]) - self.residuals(ends[0])) / (ends[1][k] - ends[0][k]))
        return np.stack(columns, axis=1)

    def profiles(self, best: Array, threshold: float) -> tuple[list[list[tuple[float, float]]], list[list[float | None]], Array | None]:
        """Profiles, ends of the intervals, and a better fit where one is found on the way."""
        from scipy.optimize import brentq
        least, curvature = self.chi_square(best), np.linalg.norm(self.jacobian(best), axis=0)
        profiles: list[list[tuple[float, float]]] = []
        ends: list[list[float | None]] = []
        for k in range(best.size):
            points, sides = [(float(best[k]), 0.0)], list[float | None]()
            for bound in (0.0, 1.0):
                near, warm, end, width = float(best[k]), best, None, max(math.sqrt(threshold) / max(curvature[k], 1e-9), 1e-6)

                def rise(value: float) -> float:
                    nonlocal warm
                    warm = self.minimise(warm, {k: value})  # noqa: B023
                    points.append((value, self.chi_square(warm) - least))  # noqa: B023
                    return points[-1][1] - threshold

                while near != bound:
                    far = max(0.0, near - width) if bound == 0.0 else min(1.0, near + width)
                    over = rise(far)
                    if over < -threshold - 0.01:
                        return [], [], warm
                    if over > 0:
                        end = float(brentq(rise, near, far, xtol=0.01 * abs(far - near)))
                        break
                    near, width = far, 2 * width
                sides.append(end)
            profiles.append(points)
            ends.append(sides)
        return profiles, ends, None

    def loose(self, best: Array) -> list[str]:
        """Sentences on combinations of parameters that the data do not fix though they may fix each with the others known."""
        _, strength, directions = np.linalg.svd(self.jacobian(best), full_matrices=True)
        strength = np.r_[strength, np.zeros(len(self.names) - strength.size)]
        notes = []
        for size, direction in zip(strength, directions, strict=True):
            parts = [f"{'+' if direction[k] * direction[np.argmax(abs(direction))] > 0 else '-'} {self.names[k]}" for k in np.flatnonzero(abs(direction) > 0.3)]
            if size < 1 and len(parts) > 1:
                notes.append(f"The data do not fix these together, only a combination of them: {', '.join(parts)}.")
        return notes


def _open(name: str, ends: Sequence[float | None], bounds: tuple[float, float]) -> str:
    """Sentence on an interval that reaches its bounds; empty where it does not."""
    if ends == [None, None]:
        return f"The data do not fix {name} between {bounds[0]:g} and {bounds[1]:g}."
    return f"The data bound {name} from {'above' if ends[0] is None else 'below'} alone." if None in ends else ""


def _pair(values: ArrayLike, errors: ArrayLike) -> tuple[Array, Array]:
    """Values and errors of one shape. Errors: `ValueError` where an error is not above 0."""
    value = np.atleast_1d(np.asarray(values, float))
    error = np.broadcast_to(np.asarray(errors, float), value.shape)
    if not (np.isfinite(value).all() and (error > 0).all()):
        raise ValueError(f"measurement: expected finite values with standard errors above 0, found {value} and {error}")
    return value, error
