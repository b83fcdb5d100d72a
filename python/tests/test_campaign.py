"""Campaigns: the table is the same whatever was killed on the way.

A stand-in for the solver keeps the times short; `test_shots_of_the_solver` fires real shots. What can turn these red: a row that is written
after its batch instead of at once, a torn line that is read, a table in the order of arrival, an id that does not know its case.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
import zlib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from distributed import LocalCluster

import ripstop
from ripstop.campaign import DASK, Plan, campaign

ROWS = 300
NAMES = ["y", "z"]


def burn(head: Any, changes: Any) -> dict[str, Any]:
    """Compute 10 ms; every 97th row has no result."""
    x = changes["/x"]
    until = time.perf_counter() + 0.01
    while time.perf_counter() < until:
        pass
    if x % 97 == 5:
        raise ValueError("bad luck\n  at five")
    return {"y": x / 3, "z": [x, "a, b"]}


def count_rows(folder: Path) -> int:
    return sum(path.read_bytes().count(b"\n") for path in folder.glob("rows/*"))


def plan(rows: int = ROWS) -> Plan:
    return Plan({"title": "stand-in"}, {"/x": list(range(rows))}, outputs=NAMES)


@pytest.fixture(scope="module")
def cluster() -> Iterator[LocalCluster]:
    import dask

    with (
        dask.config.set(DASK),
        LocalCluster(n_workers=2, threads_per_worker=1, memory_limit=0, dashboard_address=":0") as local,
    ):
        local.adapt(minimum=2, maximum=2)  # a worker that dies while it starts is replaced, too
        yield local


@pytest.fixture(scope="module")
def undisturbed(cluster: LocalCluster, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("undisturbed")
    done = campaign(plan(), folder, cluster, progress=False, compute=burn)
    assert (done.rows, done.computed, done.failed, done.retries) == (ROWS, ROWS, 4, [])
    assert len(list((folder / "rows").iterdir())) == 2  # one file for each process
    return done.table


def test_table_has_the_order_of_the_plan_and_reasons(undisturbed: Path) -> None:
    lines = undisturbed.read_text().splitlines()
    assert lines[0] == "id,/x,y,z,reason" and len(lines) == ROWS + 1
    assert lines[2].split(",", 1)[1] == '1,0.3333333333333333,"[1,""a, b""]",'
    assert lines[6].split(",", 1)[1] == "5,,,bad luck at five"
    assert len({line[:16] for line in lines}) == ROWS + 1


def test_killed_workers_change_nothing(cluster: LocalCluster, undisturbed: Path, tmp_path: Path) -> None:
    end, killed = threading.Event(), []

    def kill() -> None:
        """Kill a worker each time that another 75 rows are on the disk."""
        while not end.wait(0.02):
            workers = [worker.pid for worker in list(cluster.workers.values()) if getattr(worker, "pid", None)]
            if workers and count_rows(tmp_path) > 75 * (len(killed) + 1):
                killed.append(workers[len(killed) % len(workers)])
                with suppress(ProcessLookupError):
                    os.kill(killed[-1], signal.SIGKILL)

    killer = threading.Thread(target=kill)
    killer.start()
    try:
        done = campaign(plan(), tmp_path, cluster, progress=False, compute=burn, retries=20)
    finally:
        end.set()
        killer.join()
    assert len(killed) > 1 and done.retries and {reason for *_, reason in done.retries} == {"the worker process ended"}
    assert done.table.read_bytes() == undisturbed.read_bytes()


def test_going_on_after_everything_was_killed(cluster: LocalCluster, undisturbed: Path, tmp_path: Path) -> None:
    plan().write(tmp_path / "plan.json")
    script = tmp_path / "go.py"
    script.write_text(
        "import sys\n"
        f"sys.path[:0] = {[str(Path(__file__).parent)]!r}\n"
        "from test_campaign import burn, campaign\n"
        "if __name__ == '__main__':\n"
        f"    campaign({str(tmp_path / 'plan.json')!r}, cluster=1, progress=False, compute=burn)\n"
    )
    folder = tmp_path / "plan"
    group = subprocess.Popen([sys.executable, str(script)], start_new_session=True, stderr=subprocess.DEVNULL)
    count = 0
    while group.poll() is None and count < 20:  # scheduler, client and workers, all of them, in the middle of it
        time.sleep(0.05)
        count = count_rows(folder)
    os.killpg(group.pid, signal.SIGKILL)
    group.wait()
    assert 20 <= count < ROWS and not (folder / "table.csv").exists()
    with next(folder.glob("rows/*")).open("ab") as torn:  # a line that the kill cut off, and one that a disk has spoilt
        torn.write(b'00000000 ["0123456789abcdef",[1,2],""]\n1234abcd ["01')
    done = campaign(tmp_path / "plan.json", None, cluster, progress=False, compute=burn)
    assert 0 < done.computed <= ROWS - 20
    assert done.table.read_bytes() == undisturbed.read_bytes()


def test_lost_scheduler_is_an_error_and_the_next_call_goes_on(cluster: LocalCluster, undisturbed: Path, tmp_path: Path) -> None:
    file = tmp_path / "scheduler.json"
    quiet = {"start_new_session": True, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    common = {**quiet, "cwd": Path(__file__).parent}  # so that both find this module
    module = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--scheduler-file", str(file), "--no-dashboard", "--port", "0"]
    scheduler = subprocess.Popen(module, **common)  # type: ignore[call-overload]
    while not file.exists():
        time.sleep(0.05)
    module = [sys.executable, "-m", "distributed.cli.dask_worker", "--scheduler-file", str(file), "--no-dashboard", "--nthreads", "1"]
    worker = subprocess.Popen([*module, "--no-nanny"], **common)  # type: ignore[call-overload]

    def kill_in_the_middle() -> None:
        while count_rows(tmp_path) < 10:
            time.sleep(0.02)
        os.killpg(scheduler.pid, signal.SIGKILL)

    killer = threading.Thread(target=kill_in_the_middle)
    killer.start()
    try:
        with pytest.raises(ConnectionError, match="the scheduler is lost after .* of 300 rows; call again to go on"):
            campaign(plan(), tmp_path, json.loads(file.read_text())["address"], progress=False, compute=burn)
    finally:
        killer.join()
        os.killpg(worker.pid, signal.SIGKILL)
    done = campaign(plan(), tmp_path, cluster, progress=False, compute=burn)
    assert 0 < done.computed < ROWS
    assert done.table.read_bytes() == undisturbed.read_bytes()


def deadly(head: Any, changes: Any) -> dict[str, Any]:
    """End the worker at row 3, and find no device at row 4."""
    if changes["/x"] == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    if changes["/x"] == 4:
        raise OSError("no device")
    return {"y": changes["/x"], "z": 0}


def test_row_that_kills_its_workers_takes_no_other_down(cluster: LocalCluster, tmp_path: Path) -> None:
    done = campaign(plan(20), tmp_path, cluster, retries=1, progress=False, compute=deadly)
    table = done.to_pandas()
    assert dict(table.reason.dropna()) == {
        3: "given up after 2 attempts: the worker process ended",
        4: "given up after 2 attempts: OSError: no device",
    }
    assert list(table.y.drop([3, 4])) == [x for x in range(20) if x not in (3, 4)]
    # What was given up is not on the disk: it is tried again where workers live.
    again = campaign(plan(20), tmp_path, cluster, retries=0, progress=False, compute=deadly)
    assert (again.computed, again.failed, again.table.read_bytes() != b"") == (0, 2, True)


def test_ids_know_case_command_options_and_changes(cluster: LocalCluster, tmp_path: Path) -> None:
    def ids(**changed: Any) -> list[str]:
        asked = Plan(**{"case": {"title": "a"}, "rows": {"/x": [1, 2, 1]}, "outputs": NAMES, **changed})
        return list(campaign(asked, tmp_path, cluster, progress=False, compute=burn).to_pandas().id)

    first = ids()
    assert first[0] == first[2] != first[1] and ids() == first
    others = [ids(case={"title": "b"}), ids(run="v50"), ids(options={"precision": "f32"}), ids(rows={"/y /x": [1], "/x": [3]})]
    assert not {row for other in others for row in other} & set(first)
    longer = campaign(Plan({"title": "a"}, {"/x": [1, 2, 7]}, outputs=NAMES), tmp_path, cluster, progress=False, compute=burn)
    assert longer.computed == 1


def test_results_that_differ_are_named(cluster: LocalCluster, tmp_path: Path) -> None:
    campaign(plan(3), tmp_path, cluster, progress=False, compute=burn)
    path = next((tmp_path / "rows").iterdir())
    row = json.loads(path.read_text().splitlines()[0].partition(" ")[2])[0]
    text = json.dumps([row, [9.0, 9.0], ""], separators=(",", ":"))
    (path.parent / "other.jsonl").write_text(f"{zlib.crc32(text.encode()):08x} {text}\n")
    assert campaign(plan(3), tmp_path, cluster, progress=False, compute=burn).conflicts == [row]


def test_plans_are_checked(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="expected columns of equal length"):
        Plan({}, {"/x": [1, 2], "/y": [1]})
    with pytest.raises(ValueError, match="expected one of run, v50, found 'shoot'"):
        Plan({}, {"/x": [1]}, run="shoot")
    (tmp_path / "plan.json").write_text('{"case": {}, "row": {}}')
    with pytest.raises(ValueError, match="plan.json: expected a plan with case, rows"):
        campaign(tmp_path / "plan.json")


def test_shots_of_the_solver(cluster: LocalCluster, tmp_path: Path) -> None:
    case = ripstop.Case(
        fabric="s-720", width_mm=40, height_mm=40, shape="cylinder", diameter_mm=5.5, length_mm=42.1, mass_g=3.0, velocity_m_s=150,
        elements_per_crossover=1, mesh_grading={},
    )  # fmt: skip
    rows = {"/projectile/velocity_m_s": [150, 6000, 200], "/fabric/warp/crimp /fabric/weft/crimp": [None, None, 0.01]}
    done = campaign(Plan(case.document, rows, options={"precision": "f32"}), tmp_path, cluster, progress=False)
    shot, bad, last = done.read()
    run = case.run(backend="cpu", precision="f32", progress=False)
    assert shot["outcome"] == "perforated" and float(shot["residual_velocity_m_s"]) == run.residual_velocity_m_s
    assert bad["outcome"] == "" and "velocity_m_s" in bad["reason"] and "6000" in bad["reason"]
    other = case.with_({"/projectile/velocity_m_s": 200, "/fabric/warp/crimp": 0.01, "/fabric/weft/crimp": 0.01})
    assert float(last["absorbed_energy_j"]) == other.run(backend="cpu", precision="f32", progress=False).absorbed_energy_j
    wrong = campaign(Plan(case.document, {"/projectile/velocity_m_s": [150]}, outputs=["speed"]), tmp_path, cluster, progress=False)
    assert "expected a name of the summary, found 'speed'" in wrong.read()[0]["reason"]


def test_slurm_by_dask_jobqueue(undisturbed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A stand-in for `sbatch` runs the job script of dask-jobqueue here."""
    before = signal.getsignal(signal.SIGINT)
    commands = tmp_path / "bin"
    commands.mkdir()
    # As the real one, it copies the script, which dask-jobqueue deletes at once.
    submit = 'cp "$1" "$0.$$"\nsetsid sh "$0.$$" >/dev/null 2>&1 &\necho Submitted batch job $!'
    for name, text in (("sbatch", submit), ("scancel", 'kill -9 -- "-$1"')):
        (commands / name).write_text(f"#!/bin/sh\n{text}\n")
        (commands / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{commands}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]))
    queue = {"queue": "gpu", "jobs": 1, "memory": "1GB", "job_extra_directives": ["--gres=gpu:1"], "scheduler_options": {"dashboard_address": ":0"}}
    done = campaign(plan(), tmp_path, queue, progress=False, compute=burn)
    assert done.table.read_bytes() == undisturbed.read_bytes()
    assert signal.getsignal(signal.SIGINT) == before, "Ctrl-C would end the interpreter"
