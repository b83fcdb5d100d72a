"""Calibration: parameters come back from synthetic data within their intervals, and what data cannot fix is said. Sensitivity: indices of
functions whose indices are known, with points that fail and an output that is uncertain.

What can turn these red: an interval of the curvature alone at a bound, a profile that does not fit the others anew, a parameter without influence
that gets an interval, a combination that is taken for fixed; an index of the wrong column, an estimator without the mean taken out, a failed
point that counts as 0, intervals that know nothing of the output's own uncertainty.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from distributed import Client, LocalCluster

import ripstop
from ripstop.calibration import Limit, PictureFrame, ResidualVelocities, TensionTest, calibrate
from ripstop.sensitivity import Factor, study

CRIMP, MODULUS, STRAIN = "/fabric/warp/crimp", "/fabric/warp/modulus_gpa", "/fabric/warp/failure_strain"
A, B = "/fabric/crossover/compression/a_mm", "/fabric/crossover/compression/b_mm_n13"


def ply(**keys: Any) -> ripstop.Case:
    return ripstop.Case(
        fabric="s-720", width_mm=100, height_mm=100, shape="cylinder", diameter_mm=5.5, length_mm=42.1, mass_g=3.0, velocity_m_s=150,
        elements_per_crossover=1, mesh_grading={}, **keys,
    )  # fmt: skip


@dataclass
class Line:
    """Stand-in for a case and its model: y = a + b x, whose intervals are known."""

    document: dict[str, float] = field(default_factory=lambda: {"a": 1.0, "b": 1.0, "c": 1.0})

    def with_(self, changes: dict[str, float]) -> Line:
        return Line({**self.document, **{key.strip("/"): value for key, value in changes.items()}})


@dataclass
class Points:
    x: Any
    y: Any
    error: float
    own: float = 0.0
    step: float = 1e-3

    def observed(self) -> Any:
        return np.asarray(self.y, float), np.full(len(self.x), self.error)

    def predict(self, case: Any) -> Any:
        return case.document["a"] + case.document["b"] * self.x, np.full(len(self.x), self.own)


@pytest.mark.parametrize("own", [0.0, 0.4])
def test_intervals_of_a_line_are_those_of_the_textbook(own: float) -> None:
    rng, x = np.random.default_rng(3), np.linspace(0, 4, 20)
    data = Points(x, 2 + 0.5 * x + rng.normal(0, 0.3, 20), 0.3, own)
    found = calibrate(Line(), {"/a": (-5, 5), "/b": (-3, 3)}, [data], level=0.95)
    design = np.stack([np.ones(20), x], axis=1) / math.hypot(0.3, own)
    covariance = np.linalg.inv(design.T @ design)
    best = covariance @ design.T @ (data.y / math.hypot(0.3, own))
    for k, (value, low, high) in enumerate(found.parameters.values()):
        half = 1.95996 * math.sqrt(covariance[k, k])
        assert (value, low, high) == pytest.approx((best[k], best[k] - half, best[k] + half), abs=0.02 * half)
    assert found.freedom == 18 and found.notes == [] and found.case.document["a"] == found.parameters["/a"][0]
    assert found.to_pandas().shape == (2, 3) and min(rise for _, rise in found.profiles["/a"]) == 0


def test_what_the_data_cannot_fix_is_said() -> None:
    x = np.full(5, 2.0)
    found = calibrate(Line(), {"/a": (-5, 5), "/b": (-3, 3), "/c": (0, 1.5)}, [Points(x, x + 1, 0.1)])
    assert found.parameters["/c"][1:] == (None, None) and "The data do not fix /c between 0 and 1.5." in found.notes
    assert any(note.startswith("The data do not fix these together") and "/a" in note and "/b" in note for note in found.notes)
    above = calibrate(Line(), {"/a": (0.9, 5), "/b /c": (0.9, 3)}, [Points(np.linspace(0, 1, 9), np.linspace(1, 2, 9), 0.1)])
    assert above.parameters["/a"][1] is None and above.parameters["/a"][2] is not None
    assert "The data bound /a from above alone." in above.notes
    wrong = calibrate(Line(), {"/a": (-50, 50)}, [Points(np.linspace(0, 9, 9), np.linspace(0, 9, 9) ** 2, 0.1)])
    assert wrong.notes == [f"The model does not describe the data within their errors: chi-square {wrong.chi_square:.3g} with 8 degrees of freedom."]
    assert wrong.p_value is not None and wrong.p_value < 1e-9
    alone = calibrate(Line(), {"/a": (-5, 5)}, [Points(np.ones(1), [1.5], 0.1)])
    assert alone.p_value is None and "cannot be tested" in alone.notes[-1]


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    """Yarns drawn straight out of their crimp: 30 synthetic tension tests, modulus and crimp unknown, at 90 %."""
    case, stretch = ply(), np.linspace(1.01, 1.045, 8)
    truth = {MODULUS: 88.0, CRIMP: 0.025}
    straight = TensionTest(stretch, np.zeros(8), 4.0).predict(case.with_(truth))[0]
    rng, held = np.random.default_rng(1), dict.fromkeys(truth, 0)
    for _ in range(30):
        test = TensionTest(stretch, straight + rng.normal(0, 4.0, 8), 4.0)
        found = calibrate(case, {MODULUS: (60, 140), CRIMP: (0.005, 0.06)}, [test])
        for name, value in truth.items():
            _, low, high = found.parameters[name]
            held[name] += (low or 0) <= value <= (high or math.inf)
    # 27 on average, with a standard deviation of 1.6; of these 30, half the rise of chi-square holds 25 and 26.
    assert all(27 <= count <= 30 for count in held.values()), held


def test_round_trip_of_a_tension_test_with_held_weft_and_a_break() -> None:
    """Crimp interchange against a held weft also fixes the compression of the yarns; the break fixes the failure strain."""
    case, stretch = ply(), np.linspace(1.004, 1.03, 14)
    truth = {MODULUS: 88.0, CRIMP: 0.025, A: 0.08, B: 0.12, STRAIN: 0.031}
    bounds = {MODULUS: (60, 140), CRIMP: (0.01, 0.05), A: (0.03, 0.2), B: (0.03, 0.3), STRAIN: (0.02, 0.05)}
    test = TensionTest(stretch, np.zeros(14), 0.3, across="held", breaking_n=(1.0, 5.0))
    exact = test.predict(case.with_(truth))[0]
    assert exact[-1] == pytest.approx(88 * 0.031 * 10518.5 / 96, rel=1e-3)  # EA of S-720 with 96 GPa
    noisy = exact + np.random.default_rng(5).normal(0, np.r_[np.full(14, 0.3), 5.0])
    test = TensionTest(stretch, noisy[:-1], 0.3, across="held", breaking_n=(noisy[-1], 5.0))
    found = calibrate(case, bounds, [test])
    for name, value in truth.items():
        best, low, high = found.parameters[name]
        assert low is not None and high is not None and low < value < high and low < best < high, name
    assert found.p_value is not None and found.p_value > 0.05
    free = calibrate(case, {A: bounds[A], CRIMP: bounds[CRIMP]}, [TensionTest(stretch, straight(stretch), 0.3)])
    assert free.parameters[A][1:] == (None, None) and f"The data do not fix {A} between 0.03 and 0.2." in free.notes


def straight(stretch: Any) -> Any:
    return 10518.5 * np.maximum(0, stretch / 1.0218 - 1)


def test_tension_test_with_free_weft_is_the_closed_form() -> None:
    stretch = np.linspace(1, 1.05, 11)
    assert TensionTest(stretch, 0 * stretch, 1.0).predict(ply())[0] == pytest.approx(straight(stretch), rel=1e-4, abs=0.01)
    weft = TensionTest(stretch, 0 * stretch, 1.0, along="weft").predict(ply())[0]
    assert weft == pytest.approx(10518.5 * np.maximum(0, stretch / 1.0139 - 1), rel=1e-4, abs=0.01)


def test_round_trip_of_a_picture_frame() -> None:
    angle = np.linspace(0.02, 0.7, 18)
    keys = [f"/fabric/shear/{key}" for key in ("g1_mpa", "g2_mpa", "gamma1", "gamma2")]
    truth = dict(zip(keys, (14.0, 700.0, 0.3, 0.55)))
    exact = PictureFrame(angle, 0 * angle, 1.0, 200).predict(ply().with_(truth))[0]
    # Below locking: L t G1 γ / sin(π/4 − γ/2).
    assert exact[3] == pytest.approx(200 * 0.3 * 14 * angle[3] / math.sin(math.pi / 4 - angle[3] / 2))
    # Beyond it: the ramp has the mean of both moduli.
    assert exact[-1] == pytest.approx(200 * 0.3 * (14 * 0.3 + 357 * 0.25 + 700 * 0.15) / math.sin(math.pi / 4 - 0.35))
    error = 0.02 * exact + 1
    noisy = exact + np.random.default_rng(8).normal(0, error)
    bounds = dict(zip(keys, ((1, 50), (200, 2000), (0.2, 0.42), (0.43, 0.69))))
    found = calibrate(ply(), bounds, [PictureFrame(angle, noisy, error, 200)], level=0.99)
    for name, value in truth.items():
        _, low, high = found.parameters[name]
        assert (low or -math.inf) < value < (high or math.inf), name
    below = angle < 0.29
    unlocked = calibrate(ply(), {keys[0]: (1, 50), keys[1]: (200, 2000)}, [PictureFrame(angle[below], noisy[below], error[below], 200)])
    assert f"The data do not fix {keys[1]} between 200 and 2000." in unlocked.notes


def test_round_trip_of_residual_velocities() -> None:
    strength = f"{STRAIN} /fabric/weft/failure_strain"
    options = {"precision": "f32", "threads": 1}
    truth = ply().with_(dict.fromkeys(strength.split(), 0.031))
    values = ResidualVelocities([150, 250], [0, 0], 2.0, options).predict(truth)[0] + np.array([1.0, -1.5])
    found = calibrate(ply(), {strength: (0.024, 0.038)}, [ResidualVelocities([150, 250], values, 2.0, options)])
    _, low, high = found.parameters[strength]
    assert low is not None and high is not None and low < 0.031 < high and high - low < 0.008
    assert found.freedom == 1 and found.case.document["fabric"]["weft"]["failure_strain"] == found.parameters[strength][0]


def test_limit_is_that_of_the_case_with_its_own_error() -> None:
    options = {"precision": "f32", "threads": 1, "bracket": 0.05}
    (value,), (error,) = Limit(1.0, 1.0, options).predict(ply())
    found = ply().v50(refined=0, progress=False, **options)
    assert value == found.v50_m_s and 90 < value < 110
    # Half an interval of 90 % over 1.645.
    assert error == pytest.approx((found.high_m_s - found.low_m_s) / 2 / 1.645, rel=0.02)


def test_refusals_of_a_calibration() -> None:
    with pytest.raises(ValueError, match="/a: expected finite bounds, the lower one first"):
        calibrate(Line(), {"/a": (2, 1)}, [Points(np.ones(1), [1.0], 0.1)])
    with pytest.raises(ValueError, match="at least one parameter and one measurement"):
        calibrate(Line(), {"/a": (1, 2)}, [])
    with pytest.raises(ValueError, match="standard errors above 0"):
        calibrate(ply(), {CRIMP: (0.01, 0.02)}, [TensionTest([1.01], [1.0], 0.0)])


FACTORS: dict[str, Factor] = {name: (-math.pi, math.pi) for name in ("/a", "/b", "/c")}
# Ishigami's function with 7 and 0.1.
EXACT = {"/a": (0.3139, 0.5576), "/b": (0.4424, 0.4424), "/c": (0.0, 0.2437)}


def ishigami(head: Any, row: Any) -> dict[str, float]:
    a, b, c = row["/a"], row["/b"], row["/c"]
    return {"y": 1000 + math.sin(a) + 7 * math.sin(b) ** 2 + 0.1 * c**4 * math.sin(a)}


def ishigami_failing(head: Any, row: Any) -> dict[str, float]:
    if row["/b"] > 3.0:
        raise ripstop.RunError("unstable at 3 us")
    return ishigami(head, row)


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=":0") as cluster, Client(cluster) as client:
        yield client


@pytest.mark.parametrize(("compute", "lost"), [(ishigami, 0), (ishigami_failing, None)])
def test_sobol_indices_of_ishigami(client: Client, tmp_path: Path, compute: Any, lost: int | None) -> None:
    found = study({"title": "y"}, FACTORS, "y", samples=512, folder=tmp_path, cluster=client, compute=compute, progress=False)
    for factor, exact in EXACT.items():
        for (value, low, high), right in zip(found.indices[factor].values(), exact, strict=True):
            assert low < value < high and high - low < 0.35
            assert low - 0.02 < right < high + 0.02, (factor, value, low, high, right)
    if lost is None:
        lost = sum(point["/b"] > 3.0 for point in found.points)
        assert found.failed == {"unstable at 3 us": lost} and lost > 20
        assert found.notes[0] == f"{lost} of 2560 points have no result; the indices leave them out."
    assert np.isnan(found.values).sum() == lost and found.noise == 0
    assert list(found.to_pandas().columns) == ["S1", "S1_low", "S1_high", "ST", "ST_low", "ST_high"]


def limit(head: Any, row: Any) -> dict[str, float]:
    """A V50 of two factors, with an interval."""
    width = row["/width"]
    return {"v50_m_s": 100 + 10 * row["/x"] + 0.0 * row["/y"], "level": 0.9, "half_width_m_s/sampling": width, "half_width_m_s/bracket": 0.0}


def test_uncertainty_of_v50_widens_the_intervals_and_shifts_none(client: Client, tmp_path: Path) -> None:
    def run(width: float) -> Any:
        factors: dict[str, Factor] = {"/x": (0, 1), "/y": (0, 1), "/width": [width]}
        return study({}, factors, samples=128, folder=tmp_path, cluster=client, compute=limit, progress=False)

    exact, vague = run(0.0), run(3.0)
    assert list(exact.values) == list(vague.values)
    # 3 m/s are 1.645 standard errors; x from 0 to 1 makes a standard deviation of 10/√12.
    assert vague.noise == pytest.approx((3 / 1.645) ** 2 / (100 / 12), rel=0.01) and exact.noise == 0
    for factor, total in (("/x", 1.0), ("/y", 0.0)):
        (value, *narrow), (same, *wide) = exact.indices[factor]["ST"], vague.indices[factor]["ST"]
        assert value == same == pytest.approx(total, abs=0.05)
        assert wide[1] - wide[0] > 1.5 * (narrow[1] - narrow[0])
        assert wide[0] < total < wide[1]
    assert exact.indices["/y"]["ST"] == (0, 0, 0)
    assert vague.campaign.computed == len(set(map(str, vague.points)))


def test_morris_finds_what_does_nothing_and_leaves_broken_trajectories_out(client: Client, tmp_path: Path) -> None:
    def steps(head: Any, row: Any) -> dict[str, float]:
        if row["/kind"] == "torn":
            raise ValueError("torn off")
        return {"y": 5 * row["/x"] - 2 * row["/z"] + {"ball": 0, "rod": 4}[row["/kind"]]}

    factors: dict[str, Factor] = {"/x": (0, 2), "/nothing": (3, 4), "/z /zz": (0, 1), "/kind": ["ball", "rod", "torn", "ball"]}
    found = study({}, factors, "y", method="morris", samples=40, folder=tmp_path, cluster=client, compute=steps, progress=False)
    assert found.indices["/x"]["mu_star"] == pytest.approx((10, 10, 10))
    assert found.indices["/z /zz"]["mu_star"] == pytest.approx((2, 2, 2)) and found.indices["/nothing"]["mu_star"] == (0, 0, 0)
    value, low, high = found.indices["/kind"]["mu_star"]
    assert 5.9 < low <= value <= high and set(found.failed) == {"torn off"}
    assert {point["/kind"] for point in found.points} == {"ball", "rod", "torn"}


def test_distributions_are_those_of_salib(client: Client, tmp_path: Path) -> None:
    factors: dict[str, Factor] = {"/x": {"dist": "norm", "bounds": [10, 2]}, "/y": (0, 1)}
    found = study({}, factors, "y", samples=256, folder=tmp_path, cluster=client, compute=lambda head, row: {"y": row["/x"]}, progress=False)
    drawn = [point["/x"] for point in found.points]
    assert np.mean(drawn) == pytest.approx(10, abs=0.1) and np.std(drawn) == pytest.approx(2, abs=0.1)
    with pytest.raises(ValueError, match="found a distribution"):
        study({}, factors, "y", method="morris", folder=tmp_path)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"samples": 48}, "samples: expected a power of 2 from 2 on, found 48"),
        ({"method": "fast"}, "method: expected sobol or morris, found 'fast'"),
        ({"factors": {"/x": (2, 1)}}, "/x: expected bounds, the lower one first"),
        ({"factors": {}}, "expected at least one factor"),
        ({"output": "low_m_s"}, "expected v50 or a number of a run, found 'low_m_s'"),
    ],
)
def test_refusals_of_a_study(tmp_path: Path, change: dict[str, Any], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        study(**{"case": {}, "factors": {"/x": (0, 1)}, "output": "y", "folder": tmp_path, **change})


def test_limit_of_a_real_ply_depends_on_strength_not_on_friction(tmp_path: Path) -> None:
    strength, friction = "/fabric/warp/failure_strain /fabric/weft/failure_strain", "/projectile/friction"
    factors: dict[str, Factor] = {strength: (0.025, 0.04), friction: (0.1, 0.3)}
    found = study(ply(), factors, samples=2, folder=tmp_path, cluster=2, progress=False, precision="f32", bracket=0.02)
    assert not found.failed and 0 < found.noise < 0.05 and 70 < found.values.min() < found.values.max() < 130
    assert found.indices[strength]["ST"][0] > 0.5 > 0.2 > found.indices[friction]["ST"][0]
    assert found.plot().get_xlabel() == "index of v50, parts of its variance"
