"""Campaigns of many shots on Dask: a plan is a file, and a row is on the disk before the next begins. `README.md` has the costs.

The folder of a campaign holds `head-DIGEST.json` (case, command, options, version: with the changes of a row they give its id, a hash), `rows/`
(results: a file for each worker process, which alone appends to it, a line with a checksum for each row) and `table.csv` (all rows in the order of
the plan, nothing of clocks and machines; written under a temporary name and renamed).
"""

from __future__ import annotations

import csv
import hashlib
import io
import json
import os
import secrets
import signal
import socket
import sys
import tempfile
import time
import zlib
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from .messages import has_line, write

if TYPE_CHECKING:
    import pandas

Values = Mapping[str, Any]
Compute = Callable[[Mapping[str, Any], Values], Values]

#: Columns of a table where the plan names none: of a shot those of `shots.csv`, of a limit those of `v50.json`.
OUTPUTS = {
    "run": ["outcome", "residual_velocity_m_s", "absorbed_energy_j", "max_deflection_mm", "energy_gained"],
    "v50": ["v50_m_s", "low_m_s", "high_m_s", "level", "sigma_m_s", "half_width_m_s/sampling", "half_width_m_s/bracket", "shots", "failed"],
}
#: Seconds that a batch of rows is meant to take: long against the few ms of a task, short against what a lost worker costs.
BATCH_S = 2.0
#: A worker that dies is an attempt of ours, with a reason, of the batch that it was at: not of others that wait for it.
DASK = {"distributed.scheduler.allowed-failures": 0, "distributed.scheduler.worker-saturation": 1.0}
#: Texts for exceptions of Dask, the same for the same cause.
REASONS = {"KilledWorker": "the worker process ended", "FutureCancelledError": "the scheduler cancelled it"}


@dataclass(frozen=True)
class Plan:
    """Rows of a campaign: a case, and the changes of each row.

    `rows`: lists of equal length by JSON pointer, or by several pointers with a space between that take the same value; None leaves the case's.
    `run`: `run` or `v50`. `options`: keywords of that method. `outputs`: names of the summary; `a/b` is `b` in `a`.
    """

    case: Mapping[str, Any]
    rows: Mapping[str, Sequence[Any]]
    run: str = "run"
    options: Mapping[str, Any] = field(default_factory=dict)
    outputs: Sequence[str] = ()

    def __post_init__(self) -> None:
        if self.run not in OUTPUTS:
            raise ValueError(f"plan, /run: expected one of {', '.join(OUTPUTS)}, found {self.run!r}")
        if not self.rows or len({len(column) for column in self.rows.values()}) != 1:
            raise ValueError(f"plan, /rows: expected columns of equal length, found {({k: len(v) for k, v in self.rows.items()})}")

    def __iter__(self) -> Iterator[dict[str, Any]]:
        """Changes of each row."""
        for values in zip(*self.rows.values(), strict=True):
            yield {name: value for name, value in zip(self.rows, values, strict=True) if value is not None}

    @staticmethod
    def read(path: str | Path) -> Plan:
        """Read a plan from JSON. Errors: `ValueError` where it is none."""
        try:
            return Plan(**json.loads(Path(path).read_text("utf-8")))
        except (TypeError, json.JSONDecodeError) as error:
            raise ValueError(f"{path}: expected a plan with case, rows and, if wanted, run, options and outputs: {error}") from None

    def write(self, path: str | Path) -> Path:
        """Write the plan as JSON."""
        return _replace(Path(path), _json(self.__dict__) + "\n")


@dataclass
class Campaign:
    """State of a campaign when `campaign` returned."""

    table: Path
    #: Rows of the plan, those of them without a result, and those computed by this call.
    rows: int
    failed: int = 0
    computed: int = 0
    #: Time of this call, and of its rows alone, all workers together [s].
    wall_s: float = 0.0
    compute_s: float = 0.0
    #: Rows that were tried again: id, attempt, reason.
    retries: list[tuple[str, int, str]] = field(default_factory=list)
    #: Ids whose results differed between two workers: not one kind of device.
    conflicts: list[str] = field(default_factory=list)

    def read(self) -> list[dict[str, str]]:
        """Read the table as texts by column."""
        with self.table.open(newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def to_pandas(self) -> pandas.DataFrame:
        """Read the table."""
        import pandas
        return pandas.read_csv(self.table)


def campaign(
    plan: str | Path | Plan, folder: str | Path | None = None, cluster: Any = None, *, adapters: Sequence[str] = (), retries: int = 5,
    progress: bool | Callable[[str], None] | None = None, compute: Compute | None = None,
) -> Campaign:  # fmt: skip
    """Compute the rows of a plan that are not in the folder yet, and write the table.

    `plan`: a file, or a plan, which is then written to `folder/plan.json`. `folder`: by default the plan's name without its ending.
    `cluster`: `None` for a local worker on each core, or on each adapter; a number of local workers; the address of a scheduler; a mapping
    of keywords of `dask_jobqueue.SLURMCluster` with `jobs`; a cluster or client of Dask. Rows on a card want one process for each card:
    `adapters` are the cards of this machine by name or number, as `ripstop info` lists them, one for each local worker.
    `retries`: how often a row is tried again after its worker died or broke. `progress`: True for a line, False for none, None for one in a
    terminal or a notebook, or a function of its text. `compute`: a function of head and changes, by pointer, in place of the solver.

    A shot that fails is a row with a reason. A row that was given up because of its workers is too, but not on the disk: the next call
    tries it again. Errors: `ConnectionError` where the scheduler is lost, `RuntimeError` where no worker can compute; call again to go on.
    """
    start = time.monotonic()
    if folder is None and isinstance(plan, Plan):
        raise ValueError("campaign: expected a folder beside a plan that is no file")
    at = Path(folder) if folder is not None else Path(str(plan)).with_suffix("")
    plan, file = (plan, at / "plan.json") if isinstance(plan, Plan) else (Plan.read(plan), None)
    (at / "rows").mkdir(parents=True, exist_ok=True)
    head, digest = _head(plan, compute)
    _replace(at / f"head-{digest}.json", head)
    if file:
        plan.write(file)
    ids = [_hash(digest + _json(changes)) for changes in plan]
    done, conflicts = _read_rows(at)
    wanted: dict[str, Values] = {row: changes for row, changes in zip(ids, plan, strict=True) if row not in done}
    state = Campaign(at / "table.csv", len(ids), conflicts=conflicts)
    lost: dict[str, str] = {}
    if wanted:
        show = progress if callable(progress) else _printer(progress)
        if cluster is None and (adapters or plan.options.get("backend") == "gpu"):
            cluster = max(1, len(adapters))
        lost = _compute_all(wanted, (str(at.absolute()), digest, list(adapters), compute), cluster, retries, show, state)
        done, state.conflicts = _read_rows(at)
    results = [done.get(row, [None, lost.get(row, "not on the disk yet: the file system lags, call again")]) for row in ids]
    state.failed = sum(values is None for values, _ in results)
    _write_table(state.table, plan, ids, results)
    state.wall_s = time.monotonic() - start
    return state


def compute_row(head: Mapping[str, Any], changes: Values) -> Values:
    """Compute a row with the solver: the outputs of the plan by name."""
    import ripstop
    result = getattr(ripstop.Case(head["case"]).with_(changes), head["run"])(**head["options"], progress=False)
    return {name: _inside(result.summary, name) for name in head["outputs"]}


def compute_batch(folder: str, digest: str, adapters: list[str], compute: Compute | None, rows: list[tuple[str, Values]]) -> tuple[int, float]:
    """Compute rows on a worker, each written before the next begins. Returns their number and time [s]."""
    start = time.monotonic()
    head, journal = _load_head(folder, digest), _open_journal(folder, os.getpid())
    if adapters:
        head = {**head, "options": {**head["options"], "adapter": _take_adapter(tuple(adapters), os.getpid())[0]}}
    for row, changes in rows:
        try:
            values = (compute or compute_row)(head, {pointer: value for key, value in changes.items() for pointer in key.split()})
            record: list[Any] = [row, [values.get(name) for name in head["outputs"]], ""]
        except Exception as error:
            if not _of_case(error):  # of the worker: the row is tried again, and the worker takes no other from those that can compute
                time.sleep(BATCH_S)
                raise
            record = [row, None, " ".join(str(error).split())]
        text = _json(record)
        journal.write(f"{zlib.crc32(text.encode()):08x} {text}\n".encode())
    return len(rows), time.monotonic() - start


def _compute_all(
    wanted: dict[str, Values], batch: tuple[Any, ...], cluster: Any, retries: int, show: Callable[[str], None], state: Campaign
) -> dict[str, str]:
    """Compute rows on a cluster, two batches at a time for each worker. Returns the reasons of those given up."""
    from distributed import CancelledError, TimeoutError, wait  # noqa: A004 (that of Python from 3.11 on)
    waiting, again, running = deque(wanted), deque[str](), dict[Any, list[str]]()
    attempts, lost, timed = dict[str, int](), dict[str, str](), 0
    with ExitStack() as stack:
        client = _connect(cluster, stack)
        while waiting or again or running:
            if client.status != "running":
                raise ConnectionError(f"{batch[0]}: the scheduler is lost after {state.computed} of {len(wanted)} rows; call again to go on")
            workers = max(1, len(client.nthreads()))
            each = state.compute_s / timed if timed else BATCH_S
            while (waiting or again) and len(running) < 2 * workers:
                size = max(1, min(int(BATCH_S / max(each, 1e-4)), len(waiting) // (2 * workers)))
                rows = [again.popleft()] if again else [waiting.popleft() for _ in range(size)]
                orders, key = [(row, wanted[row]) for row in rows], f"ripstop-{rows[0]}-{secrets.token_hex(4)}"
                running[client.submit(compute_batch, *batch, orders, key=key, pure=False)] = rows
            with suppress(TimeoutError, CancelledError):
                wait(list(running), timeout=1, return_when="FIRST_COMPLETED")
            failed = []
            for task in [task for task in running if task.done()]:
                rows = running.pop(task)
                try:
                    count, seconds = task.result()  # fails, too, where its worker died after the last row
                    state.computed, timed, state.compute_s = state.computed + count, timed + count, state.compute_s + seconds
                except Exception as error:
                    name = type(error).__name__
                    failed.append((rows, REASONS.get(name) or f"{name}: {' '.join(str(error).split())}"))
            done = _read_rows(Path(batch[0]))[0] if failed else {}
            for rows, reason in failed:
                left = [row for row in rows if row not in done]
                state.computed += len(rows) - len(left)
                waiting.extendleft(left[:0:-1])
                if not state.computed and len(state.retries) >= 10 * workers:
                    raise RuntimeError(f"{batch[0]}: no worker has computed a row in {len(state.retries)} attempts: {reason}")
                # A batch goes in order: the first row without a result is the suspect, and runs alone, so that it takes no other down.
                for suspect in left[:1]:
                    attempts[suspect] = attempts.get(suspect, 0) + 1
                    state.retries.append((suspect, attempts[suspect], reason))
                    if attempts[suspect] > retries:
                        lost[suspect] = f"given up after {attempts[suspect]} attempts: {reason}"
                    else:
                        again.append(suspect)
            rest = len(wanted) - state.computed - len(lost)
            minutes = f"{rest * state.compute_s / timed / workers / 60:.1f} min left" if timed else "time left not known yet"
            show(f"{len(wanted) - rest} of {len(wanted)} rows, {workers} workers, {len(state.retries)} tried again, {minutes}")
    show("")
    return lost


def _connect(cluster: Any, stack: ExitStack) -> Any:
    """Connect to a cluster as `campaign` describes it; what was started ends with the stack."""
    import dask
    from distributed import Client, LocalCluster
    if isinstance(cluster, Client):
        return cluster
    stack.enter_context(dask.config.set(DASK))
    if isinstance(cluster, Mapping):
        interrupt = signal.getsignal(signal.SIGINT)
        from dask_jobqueue.slurm import SLURMCluster
        if signal.getsignal(signal.SIGINT) != interrupt:
            signal.signal(signal.SIGINT, interrupt)  # the import lets Ctrl-C end the interpreter
        keywords = {"cores": 1, "processes": 1, "memory": "4GB", **cluster}
        workers = keywords.pop("jobs", 1) * keywords["processes"]
        cluster = stack.enter_context(SLURMCluster(**keywords))
        # Not `scale`: workers that ended, such as those of jobs at the end of their time, come again.
        cluster.adapt(minimum=workers, maximum=workers)
    elif cluster is None or isinstance(cluster, int):
        count = cluster or (len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()) or 1
        cluster = stack.enter_context(LocalCluster(n_workers=count, threads_per_worker=1, memory_limit=0, dashboard_address=":0"))
        cluster.adapt(minimum=count, maximum=count)
    return stack.enter_context(Client(cluster))


def _of_case(error: Exception) -> bool:
    """Whether an error belongs to the case, and comes again wherever it is computed: bad values, or a run without a result."""
    device, run = (getattr(sys.modules.get("ripstop"), name, ()) for name in ("DeviceError", "RunError"))
    return isinstance(error, (ValueError, run)) and not isinstance(error, device)


def _head(plan: Plan, compute: Compute | None) -> tuple[str, str]:
    """Head of a plan as text, and its digest."""
    import ripstop
    # One thread: as many shots run as there are workers. A shot does not depend on it.
    head = {**plan.__dict__, "rows": None, "options": {"threads": 1, "backend": "cpu", **plan.options}, "version": ripstop.__version__}
    text = _json(head | {"outputs": list(plan.outputs or OUTPUTS[plan.run]), "compute": getattr(compute, "__qualname__", None)})
    return text, _hash(text)


def _hash(text: str) -> str:
    return hashlib.blake2b(text.encode(), digest_size=8).hexdigest()


def _json(value: Any) -> str:
    """JSON on one line, the same for the same value."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=True)


def _inside(summary: Mapping[str, Any], name: str) -> Any:
    """Value of a summary by name."""
    value: Any = summary
    for part in name.split("/"):
        if not isinstance(value, Mapping) or part not in value:
            raise ValueError(f"output: expected a name of the summary, found {name!r}; there are {', '.join(summary)}")
        value = value[part]
    return value


@lru_cache(maxsize=4)
def _load_head(folder: str, digest: str) -> Any:
    return json.loads((Path(folder) / f"head-{digest}.json").read_text("utf-8"))


@lru_cache(maxsize=4)
def _open_journal(folder: str, process: int) -> BinaryIO:
    """Open this process' file of rows. Unbuffered: a row that `write` took survives a kill."""
    return open(Path(folder) / "rows" / f"{socket.gethostname()}-{process}-{secrets.token_hex(4)}.jsonl", "ab", buffering=0)


@lru_cache(maxsize=4)
def _take_adapter(adapters: tuple[str, ...], process: int) -> tuple[str, Any]:
    """Take an adapter of this machine that no other process has, until this one ends. Errors: `RuntimeError` where there is none."""
    import fcntl
    for adapter in adapters:
        lock = open(Path(tempfile.gettempdir(), f"ripstop-adapter-{_hash(adapter)}.lock"), "w")
        with suppress(BlockingIOError):
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return adapter, lock
        lock.close()
    raise RuntimeError(f"more workers on {socket.gethostname()} than adapters: {', '.join(adapters)}")


def _read_rows(folder: Path) -> tuple[dict[str, list[Any]], list[str]]:
    """Read all rows by id, as values and reason, and the ids with two different results; the lesser text then counts, always the same."""
    texts: dict[str, str] = {}
    conflicts: set[str] = set()
    for path in sorted((folder / "rows").glob("*.jsonl")):
        for line in path.read_bytes().split(b"\n"):
            checksum, _, text = line.partition(b" ")
            if len(checksum) != 8 or checksum != b"%08x" % zlib.crc32(text):
                continue
            row, found = json.loads(text)[0], text.decode()
            if texts.setdefault(row, found) != found:
                conflicts.add(row)
                texts[row] = min(texts[row], found)
    return {row: json.loads(text)[1:] for row, text in texts.items()}, sorted(conflicts)


def _write_table(path: Path, plan: Plan, ids: Sequence[str], results: Sequence[Sequence[Any]]) -> None:
    outputs = list(plan.outputs or OUTPUTS[plan.run])
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(["id", *plan.rows, *outputs, "reason"])
    for row, changes, (values, reason) in zip(ids, plan, results, strict=True):
        cells = [*(changes.get(name) for name in plan.rows), *(values or [None] * len(outputs))]
        writer.writerow([row, *(cell if cell is None or isinstance(cell, str) else _json(cell) for cell in cells), reason])
    _replace(path, buffer.getvalue())


def _replace(path: Path, text: str) -> Path:
    """Write a file under a temporary name and rename it: it is complete or not there."""
    temporary = path.with_name(f".{path.name}-{os.getpid()}")
    temporary.write_bytes(text.encode())
    temporary.replace(path)
    return path


def _printer(progress: bool | None) -> Callable[[str], None]:
    """Printer of progress on a line of standard error, once a second at most."""
    last = 0.0

    def show(text: str) -> None:
        nonlocal last
        if not text or time.monotonic() - last > 1:
            last = time.monotonic()
            write(text)

    return show if has_line(progress) else lambda text: None
