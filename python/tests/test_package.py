"""The package against the program: same bits, same words, same files; and what Python adds. Notebooks run from a kernel of their own.

The program is target/release/ripstop, or the file that RIPSTOP names. What can turn notebooks red: a cell that raises, outputs stored in a
notebook, one that says what its own numbers do not show.
"""

from __future__ import annotations

import csv
import json
import os
import pickle
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import nbformat
import numpy as np
import pytest
from nbclient import NotebookClient

import ripstop

ROOT = Path(__file__).parents[2]
PROGRAM = os.environ.get("RIPSTOP", str(ROOT / "target/release/ripstop"))
#: A small ply that a small ball perforates.
CASE = {
    "title": "a small ply at 300 m/s",
    "fabric": {"file": "fabrics/s-720.json"},
    "pack": {"plies": 1, "width_mm": 8, "height_mm": 8, "edges": "clamped", "friction": 0.2},
    "projectile": {"shape": "sphere", "diameter_mm": 3, "mass_g": 0.05, "velocity_m_s": 300, "friction": 0.2},
    "solver": {"end_time_us": 100},
    "output": {"history_interval_us": 0.5, "profile_times_us": [2, 4]},
    "variability": {"seed": 3, "modulus": {"scatter": 0.15}},
    "sources": {"": "made for tests"},
}
#: Changes that make cases/verify/mirror.json one that becomes unstable.
BENT = {
    "/projectile": None,
    "/fabric/weft/crimp": 0,
    "/pack/width_mm": 5.08,
    "/pack/height_mm": 8.89,
    "/pack/edges": "clamped",
    "/pack/initial_deflection": {"amplitude_mm": 0.0006, "warp_half_waves": 0, "weft_half_waves": 2},
    "/solver/end_time_us": 120,
    "/output/history_interval_us": 2,
    "/solver/courant": 0.99,
}
#: Changes that make it a pack.
PACK = ["--set", "/pack/plies=2", "--set", "/projectile/velocity_m_s=280"]
#: Numbers of a summary that are the machine's.
CLOCKS = {"wall_s", "loop_s", "element_steps_per_s", "timings", "host_overhead_s"}
NOTEBOOKS = ROOT / "python/notebooks"
#: Pattern of what the outputs of each notebook hold.
SHOWN = {
    "first-shot": r"PERFORATED: leaves at 2\d\d m/s.*did you mean \"mass_g\"",
    "v50": r"as published: V50 \d+",
    "which-parameters-matter": r"16 limits, 16 computed",
    "calibration": r"The data do not fix /fabric/crossover/compression/a_mm between 0.02 and 0.25",
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Folder with the case, in which the test runs, on a machine without graphics adapters."""
    (tmp_path / "shot.json").write_text(json.dumps(CASE))
    shutil.copytree(ROOT / "cases/fabrics", tmp_path / "fabrics")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("VK_DRIVER_FILES", "/dev/null")
    monkeypatch.setenv("VK_ICD_FILENAMES", "/dev/null")
    return tmp_path


def program(*arguments: str, code: int = 0) -> str:
    done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True)
    assert done.returncode == code, done.stderr
    return done.stdout if code == 0 else done.stderr


def rows(path: str) -> dict[str, list[str]]:
    names, *lines = csv.reader(Path(path).read_text().splitlines())
    return dict(zip(names, map(list, zip(*lines)), strict=True))


def same(table: ripstop.Table, path: str) -> None:
    """The table has the very numbers of the file."""
    found = rows(path)
    assert list(table) == list(found)
    for name, cells in found.items():
        assert [str(cell) if table[name].dtype.kind == "U" else float(cell) for cell in table[name]] == [
            cell if table[name].dtype.kind == "U" else float(cell) for cell in cells
        ], name


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_a_run_has_the_bits_of_the_program(folder: Path, precision: Any) -> None:
    program("run", "shot.json", *PACK, "--backend", "cpu", "--precision", precision, "-o", "theirs")
    case = ripstop.Case("shot.json").with_({"/pack/plies": 2, "/projectile/velocity_m_s": 280})
    run = case.run("cpu", precision=precision, threads=1, out="ours")
    same(run.history, "theirs/history.csv")
    for name in ("events", "plies", "profiles"):
        same(run.table_of(name), f"theirs/{name}.csv")
    theirs = json.loads(Path("theirs/summary.json").read_text())
    assert set(theirs) == set(run.summary)
    assert all(run.summary[key] == theirs[key] for key in theirs.keys() - CLOCKS - {"threads"})
    assert run.outcome == "perforated" and run.residual_velocity_m_s > 0 and run.table_of("events")["yarn"].size > 0
    for name in ("history.csv", "events.csv", "plies.csv", "profiles.csv", "case.json", "shot.svg"):
        assert Path("ours", name).read_bytes() == Path("theirs", name).read_bytes(), name
    assert "playback" in Path("ours/report.html").read_text()


def test_frames_are_those_of_the_program(folder: Path) -> None:
    import pyvista

    program("run", "shot.json", *PACK, "--backend", "cpu", "--frames", "4", "-o", "out", "--quiet")
    frames = ripstop.Case("shot.json").with_({"/pack/plies": 2, "/projectile/velocity_m_s": 280}).run("cpu", frames=4).frames
    files = sorted(Path("out/frames").glob("fabric_*.vtu"))
    assert len(frames) == len(files) >= 4
    for frame, file in zip(frames, files, strict=True):
        theirs, ours = pyvista.read(file), frame.mesh(broken=True)
        # Places are rounded once in the file, and here after the displacement too.
        assert np.allclose(ours.points, theirs.points, rtol=0, atol=1e-6) and np.array_equal(frame.corners.ravel(), theirs.cell_connectivity)
        for name in [*theirs.point_data, *(name for name in theirs.cell_data if name != "vtkGhostType")]:
            assert np.array_equal(ours[name], theirs[name]), name
        assert ours.n_cells - frame.mesh().n_cells == np.count_nonzero(theirs.cell_data["vtkGhostType"])
    assert frames[-1].mesh().n_cells < frames[0].mesh().n_cells, "nothing broke"
    path = [frame.projectile["position_mm"][2] for frame in frames]
    assert path == sorted(path) and frames[0].projectile["velocity_m_s"][2] == pytest.approx(280, abs=1)


def test_studies_write_the_files_of_the_program(folder: Path) -> None:
    case = ripstop.Case("shot.json")
    program("shots", "shot.json", "--count", "6", "--velocity", "40..300", "--seed", "5", "-o", "theirs", "--quiet")
    # A batch that the program began goes on here.
    program("shots", "shot.json", "--count", "2", "--velocity", "40..300", "--seed", "5", "-o", "ours", "--quiet")
    shots = case.shots(6, velocity_m_s=(40, 300), seed=5, out="ours", threads=2)
    assert sorted(path.name for path in Path("ours").iterdir()) == sorted(path.name for path in Path("theirs").iterdir())
    for path in Path("theirs").iterdir():
        assert Path("ours", path.name).read_bytes() == path.read_bytes(), path.name
    assert {"stopped", "perforated"} <= set(shots.table["outcome"]) | {"rebounded"} and len(shots.table["shot"]) == 6
    assert shots.summary == json.loads(Path("theirs/shots.json").read_text()) and shots.page == Path("theirs/shots.html").read_text()

    program("v50", "shot.json", "--count", "2", "--refined", "0", "--bracket", "5", "-o", "limit", "--quiet")
    limit = case.v50(2, refined=0, bracket=0.05)
    assert limit.folder is None and limit.summary == json.loads(Path("limit/v50.json").read_text())
    assert limit.low_m_s < limit.v50_m_s < limit.high_m_s and f"{limit.v50_m_s:.4g} m/s" in repr(limit)

    over = ["--over", "/pack/plies=1,2", "--over", "/projectile/velocity_m_s=100,300"]
    program("sweep", "shot.json", *over, "-o", "grid", "--quiet")
    grid = case.sweep({"/pack/plies": [1, 2], "/projectile/velocity_m_s": np.array([100, 300])})
    assert grid.summary == json.loads(Path("grid/sweep.json").read_text())
    assert np.array_equal(grid.table["residual_velocity_m_s"], np.array(rows("grid/sweep.csv")["residual_velocity_m_s"], float))


def test_check_crossover_and_fit_are_those_of_the_program(folder: Path) -> None:
    case = ripstop.Case("shot.json").with_({"/pack/plies": 3})
    sheet = json.loads(program("check", "shot.json", "--set", "/pack/plies=3", "--json"))
    assert case.check() == sheet and sheet["fabrics"][0]["plies"] == 3
    stretches = ["--warp-stretch", "1:1.03:4", "--weft-stretch", "0.99", "--law", "kawabata", "--csv"]
    Path("cell.csv").write_text(program("crossover", "shot.json", *stretches))
    same(ripstop.crossover(case, [1 + 0.03 * n / 3 for n in range(3)] + [1.03], 0.99, "kawabata"), "cell.csv")
    columns = {"velocity_m_s": np.array([100.0, 120, 140, 110, 130]), "perforated": [False, False, True, True, True]}
    Path("range.csv").write_text("velocity_m_s,perforated\n100,0\n120,0\n140,1\n110,1\n130,1\n")
    theirs = json.loads(program("fit", "range.csv", "--level", "0.95", "--json"))
    for data in ("range.csv", columns):
        assert ripstop.fit(data, level=0.95).summary == theirs  # type: ignore[arg-type]
    assert ripstop.fit(columns).mu == theirs["mu"] and theirs["perforated"] == 3


def test_a_case_is_that_of_file_dict_keywords_and_pickle(folder: Path) -> None:
    changes = {"/pack/plies": 1, "/projectile/velocity_m_s": 120.5, "/pack/edges": "free"}
    file = ripstop.Case("shot.json")
    changed = file.with_(changes)
    steps = file.with_({"/pack/plies": 1}).with_({"/projectile/velocity_m_s": 120.5, "/pack/edges": "free"})
    sets = [part for pointer, value in changes.items() for part in ("--set", f"{pointer}={value}")]
    program("run", "shot.json", *sets, "--set", "/solver/end_time_us=1", "--backend", "cpu", "--quiet")
    theirs = json.loads(next(Path("out").glob("*/summary.json")).read_text())
    short = changed.with_({"/solver/end_time_us": 1})
    assert (short.name, short.title) == (theirs["case"], theirs["title"]) and short.run().case_hash == theirs["case_hash"]
    assert changed.document == steps.document and (changed.title, changed.name) == (steps.title, steps.name)
    for other in (ripstop.Case(CASE).with_(changes), pickle.loads(pickle.dumps(changed))):
        assert other.document == changed.document and other.title == changed.title
    assert pickle.loads(pickle.dumps(changed)).with_({"/pack/plies": 4}).name == changed.with_({"/pack/plies": 4}).name
    flat = ripstop.Case(fabric="s-720", width_mm=12, height_mm=12, plies=2, shape="sphere", diameter_mm=4, mass_g=0.3, velocity_m_s=300)
    assert flat.document["pack"] == {"width_mm": 12, "height_mm": 12, "plies": 2} and flat.document["projectile"]["mass_g"] == 0.3
    assert file.document["projectile"]["velocity_m_s"] == 300, "a case does not change"


def test_refusals_are_those_of_the_program(folder: Path) -> None:
    case = ripstop.Case("shot.json")
    Path("bad.json").write_text(json.dumps(CASE | {"pack": {"pliess": 2}}))
    with pytest.raises(ripstop.CaseError) as refused:
        ripstop.Case("bad.json")
    assert str(refused.value) + "\n" == program("check", "bad.json", code=2) and "pliess" in str(refused.value)
    with pytest.raises(ripstop.CaseError) as refused:
        case.with_({"/projectile/mass": 3, "/pack/plies": "many"})
    assert str(refused.value) + "\n" == program("check", "shot.json", "--set", "/projectile/mass=3", "--set", "/pack/plies=many", code=2)
    with pytest.raises(ripstop.DeviceError) as lost:
        case.run("gpu", adapter="no such")
    assert str(lost.value) + "\n" == program("run", "shot.json", "--backend", "gpu", "--adapter", "no such", code=3)
    # Straight yarns of a bent ply, heated by too long a step (tests/conservation.rs).
    mirror = str(ROOT / "cases/verify/mirror.json")
    arguments = [part for pointer, value in BENT.items() for part in ("--set", f"{pointer}={json.dumps(value)}")]
    with pytest.raises(ripstop.RunError) as unstable:
        ripstop.Case(mirror).with_(BENT).run("cpu")
    assert str(unstable.value) + "\n" == program("run", mirror, *arguments, "--backend", "cpu", "--quiet", code=1)
    assert unstable.value.result.unstable["step"] > 0 and "UNSTABLE" in unstable.value.result.verdict
    endless = {"/fabric/warp/failure_strain": 1, "/fabric/weft/failure_strain": 1, "/pack/plies": 1, "/solver/end_time_us": 5}
    sets = [part for pointer, value in endless.items() for part in ("--set", f"{pointer}={value}")]
    with pytest.raises(ripstop.RunError) as missing:
        case.with_(endless).v50(1, refined=0)
    assert str(missing.value) + "\n" == program("v50", "shot.json", *sets, "--count", "1", "--refined", "0", "-o", "none", "--quiet", code=1)
    assert missing.value.result.v50_m_s is None and missing.value.result.table["shot"].size > 0


@pytest.mark.parametrize(
    ("call", "where", "found"),
    [
        (lambda case: case.run("gpux"), "backend", "'gpux'"),
        (lambda case: case.run("gpu", precision="f64"), "--precision f64", "f64"),
        (lambda case: case.run("cpu", adapter="x"), "--adapter", "--backend cpu"),
        (lambda case: case.run(precision="f16"), "precision", "'f16'"),
        (lambda case: case.run(threads=0), "threads", "0"),
        (lambda case: case.run(frames=10**6), "frames", "1000000"),
        (lambda case: case.run(frames=2.5), "arguments", "floating point"),
        (lambda case: case.shots(0), "count", "0"),
        (lambda case: case.shots(1, velocity_m_s=(200, 100)), "velocity_m_s", "(200, 100)"),
        (lambda case: case.shots(1, seed=-1), "arguments", "-1"),
        (lambda case: case.v50(level=2), "level", "2"),
        (lambda case: case.v50(bracket=float("nan")), "bracket", "nan"),
        (lambda case: case.sweep({}), "over", "none"),
        (lambda case: case.sweep({"/pack/plies": [10**9]}), "shot.json: --set /pack/plies", "1e9"),
        (lambda case: case.sweep({"/pack/plies": range(1, 999), "/projectile/velocity_m_s": range(1, 99)}), "--over", "97804"),
        (lambda case: case.with_({"pack": 1}), "shot.json: --set pack=1", '"pack"'),
        (lambda case: ripstop.Case("absent.json"), "absent.json", "No such file"),
        (lambda case: ripstop.Case("shot.json", plies=2), "Case", "two of them"),
        (lambda case: ripstop.Case(friction=2), "keywords", "friction"),
        (lambda case: ripstop.Case(colour=2), "keywords", "colour"),
        (lambda case: ripstop.Case({"title": 3}, name="mine"), "mine", "3"),
        (lambda case: ripstop.crossover(case, 3), "warp_stretch", "3"),
        (lambda case: ripstop.crossover(case, [1.0] * 2000, [1.0] * 2000), "warp_stretch, weft_stretch", "2000 × 2000"),
        (lambda case: ripstop.crossover(case, 1, 1, "hooke"), "law", "hooke"),
        (lambda case: ripstop.fit("absent.csv"), "absent.csv", "No such file"),
        (lambda case: ripstop.fit({"velocity_m_s": [1]}, columns={"speed": "v"}), "columns", "speed"),
    ],
)
def test_bad_input_gets_one_clear_error(folder: Path, call: Any, where: str, found: str) -> None:
    with pytest.raises(ripstop.CaseError) as refused:
        call(ripstop.Case("shot.json"))
    first, *others = str(refused.value).splitlines()
    assert first.startswith(f"error: {where}"), refused.value
    assert any(line.startswith("  expected: ") for line in others)
    assert any(line.startswith("  found: ") and found in line for line in others), refused.value


@pytest.fixture
def ctrl_c() -> Iterator[None]:
    """Ctrl-C as a terminal has it: what a shell starts in the background ignores it, and Python then does, too."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("ctrl_c")
def test_ctrl_c_ends_cleanly_and_loses_nothing(folder: Path) -> None:
    long = ripstop.Case("shot.json").with_({"/pack/width_mm": 80, "/pack/height_mm": 80, "/solver/run_until": "end_time", "/solver/end_time_us": 900})
    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt, match="interrupted at") as stopped:
        long.run("cpu", progress=False)
    assert isinstance(stopped.value, ripstop.Interrupted) and time.monotonic() - start < 5
    run = stopped.value.result
    assert run.interrupted and 0 < run.time_us < 900 and run.history["time_us"][-1] == run.time_us
    with pytest.raises(ZeroDivisionError):
        long.run("cpu", progress=lambda at: 1 / 0)

    case = ripstop.Case("shot.json")
    whole = case.shots(20, velocity_m_s=(40, 300))
    with pytest.raises(ripstop.Interrupted, match="rows so far") as broken:
        case.shots(20, velocity_m_s=(40, 300), threads=1, progress=lambda at: at["done"] >= 2 and os.kill(os.getpid(), signal.SIGINT))
    assert broken.value.folder and 2 < len(Path(broken.value.folder, "shots.csv.partial").read_text().splitlines()) < 21
    again = case.shots(20, velocity_m_s=(40, 300), out=broken.value.folder, resume=True)
    assert again.page == whole.page and all(np.array_equal(again.table[name], whole.table[name], equal_nan=whole.table[name].dtype.kind == "f") for name in whole.table)


def test_other_threads_go_on_and_progress_is_shown(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    case = ripstop.Case("shot.json").with_({"/pack/width_mm": 50, "/pack/height_mm": 50, "/projectile/velocity_m_s": 60})
    seen: list[dict[str, float]] = []
    ticks, done = [0], threading.Event()

    def tick() -> None:
        while not done.wait(0.001):
            ticks[0] += 1

    thread = threading.Thread(target=tick)
    thread.start()
    start = time.monotonic()
    run = case.run("cpu", progress=lambda at: seen.append(dict(at)))  # type: ignore[arg-type]
    wall = time.monotonic() - start
    done.set()
    thread.join()
    assert ticks[0] > 100 * wall, "the interpreter was locked"
    times = [at["time_us"] for at in seen]
    assert 0 < len(seen) <= 10 * wall + 1 and times == sorted(times) and times[-1] <= run.time_us and seen[0]["end_time_us"] == 100
    capfd.readouterr()
    case.shots(3, progress=True)
    line = capfd.readouterr().err
    assert "shots, " in line and " of 3, " in line and line.endswith("\r") and line.split("\r")[-2].strip() == "", "the line stays"
    case.shots(1, progress=False)
    case.shots(1)
    assert capfd.readouterr().err == ""


def test_results_are_drawn_and_shown(folder: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    case = ripstop.Case("shot.json")
    run, shots, limit = case.run("cpu"), case.shots(12, velocity_m_s=(40, 300)), case.v50(3, refined=0, bracket=0.03)
    grid = case.sweep({"/projectile/velocity_m_s": [100, 300], "/pack/edges": ["clamped", "free"]})

    def lines(ax: Any) -> dict[str, Any]:
        return {line.get_label(): line.get_xydata() for line in ax.lines}

    time_us, history = run.history["time_us"], run.history
    for ax, column in ((run.plot(), "projectile_velocity_m_s"), (ripstop.plot.force(run), "contact_force_n")):
        assert np.array_equal(ax.lines[0].get_xydata(), np.c_[time_us, history[column]]) and ax.get_xlabel() == "time [µs]"
    drawn = lines(ripstop.plot.energies(run))
    assert np.array_equal(drawn["projectile"][:, 1], history["projectile_energy_j"]) and {"fabric, kinetic", "yarn failure"} <= set(drawn)
    measured = {"time_us": [1.0, 2.0], "projectile_velocity_m_s": [290.0, 280.0]}
    both = lines(ripstop.overlay({"a": run, "b": run}, measured=measured))
    assert set(both) == {"a", "b", "measured"} and both["measured"].tolist() == [[1, 290], [2, 280]]
    drawn = lines(shots.plot())
    left = shots.table["residual_velocity_m_s"][shots.table["outcome"] == "perforated"]
    assert np.array_equal(drawn["perforated"][:, 1], left) and len(drawn["stopped"]) + len(left) == 12 and len(drawn) == 4
    assert not drawn["stopped"][:, 1].any()
    assert drawn[next(name for name in drawn if "Recht" in name)][0].tolist() == [shots.residual[0]["limit"], 0]
    ax = limit.plot()
    curve = ax.lines[0].get_xydata()
    assert np.interp(limit.v50_m_s, *curve.T) == pytest.approx(0.5, abs=1e-3) and curve[0, 1] < 1e-4 and curve[-1, 1] > 1 - 1e-4
    assert len(ax.collections[0].get_paths()) == len(limit.quantiles) and "stopped" in lines(ax)
    assert len(ripstop.fit({"velocity_m_s": shots.table["velocity_m_s"], "perforated": shots.table["perforated"]}).plot().lines) >= 1
    drawn = lines(grid.plot())
    assert set(drawn) == {"edges: clamped", "edges: free"} and drawn["edges: free"].shape == (2, 2)
    plt.close("all")

    for result, words in ((run, run.verdict.split(": ")[1].split(",")[0]), (shots, "12 shots"), (limit, "V50"), (grid, "Sweep")):
        shown = result._repr_html_()
        assert shown.startswith("<iframe srcdoc=") and "&lt;svg" in shown and words.lower() in shown.lower()
    assert run.to_pandas().equals(run.history.to_pandas()) and list(limit.to_pandas()["outcome"]) == list(limit.table["outcome"])
    assert "absorbed_energy_j" in dir(run) and not hasattr(run, "absorbed_energy")


def test_the_readme_does_what_it_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    names: dict[str, Any] = {}
    blocks = (ROOT / "python/README.md").read_text().split("```python\n")[1:]
    for block in blocks:
        exec(block.split("```")[0], names)
    assert len(blocks) == 2 and names["run"].verdict.startswith("PERFORATED: leaves at ") and names["case"].document["pack"]["plies"] == 2


def test_import_takes_no_heavy_library_and_the_module_is_small() -> None:
    script = "import ripstop, sys; print(*sys.modules)"
    modules = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    assert not {"pandas", "matplotlib", "scipy", "SALib", "pyvista", "distributed", "dask"} & set(modules.split())
    assert os.path.getsize(ripstop._ripstop.__file__) < 20e6


def texts(output: Any) -> str:
    return str(output.get("text", "")) + "".join(str(text) for kind, text in output.get("data", {}).items() if kind.startswith("text/"))


def test_there_are_four_without_outputs() -> None:
    files = sorted(NOTEBOOKS.glob("*.ipynb"))
    assert {file.stem for file in files} == SHOWN.keys()
    for file in files:
        notebook = nbformat.read(file, as_version=4)
        nbformat.validate(notebook)
        assert file.stat().st_size < 20_000 and not any(cell.get("outputs") for cell in notebook.cells)


@pytest.mark.parametrize("name", SHOWN)
def test_notebook_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RIPSTOP_SAMPLES", "2")
    monkeypatch.setenv("RIPSTOP_REALISATIONS", "2")
    notebook = nbformat.read(NOTEBOOKS / f"{name}.ipynb", as_version=4)
    NotebookClient(notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    assert re.search(SHOWN[name], "\n".join(map(texts, outputs)), re.S)
    figures = sum("image/png" in output.get("data", {}) for output in outputs)
    assert figures >= {"first-shot": 3, "v50": 2, "which-parameters-matter": 3, "calibration": 2}[name]
