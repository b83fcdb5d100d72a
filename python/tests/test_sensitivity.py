"""Sensitivity: indices of functions whose indices are known, with points that fail and an output that is uncertain.

What can turn these red: an index of the wrong column, an estimator without the mean taken out, a failed point that counts as 0, intervals that
know nothing of the output's own uncertainty.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from distributed import Client, LocalCluster

import ripstop
from ripstop.sensitivity import Factor, study

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
def test_refusals(tmp_path: Path, change: dict[str, Any], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        study(**{"case": {}, "factors": {"/x": (0, 1)}, "output": "y", "folder": tmp_path, **change})


def test_limit_of_a_real_ply_depends_on_strength_not_on_friction(tmp_path: Path) -> None:
    case = ripstop.Case(
        fabric="s-720", width_mm=100, height_mm=100, shape="cylinder", diameter_mm=5.5, length_mm=42.1, mass_g=3.0, velocity_m_s=100,
        elements_per_crossover=1, mesh_grading={},
    )  # fmt: skip
    strength, friction = "/fabric/warp/failure_strain /fabric/weft/failure_strain", "/projectile/friction"
    factors: dict[str, Factor] = {strength: (0.025, 0.04), friction: (0.1, 0.3)}
    found = study(case, factors, samples=2, folder=tmp_path, cluster=2, progress=False, precision="f32", bracket=0.02)
    assert not found.failed and 0 < found.noise < 0.05 and 70 < found.values.min() < found.values.max() < 130
    assert found.indices[strength]["ST"][0] > 0.5 > 0.2 > found.indices[friction]["ST"][0]
    assert found.plot().get_xlabel() == "index of v50, parts of its variance"
