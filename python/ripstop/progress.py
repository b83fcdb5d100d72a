"""Progress of a run or a study: one line that is written over, in a terminal or a notebook."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

#: Receiver of progress: numbers by name, units in the names.
Receiver = Callable[[Mapping[str, float | None]], object]

WIDTH = 79
FIRST = 0.1  #: Time before which nothing is written [s].


def line(what: str, at: Mapping[str, float | None]) -> str:
    """Progress in words."""
    number = {name: value for name, value in at.items() if value is not None}
    if "time_us" in number:
        return "{what}, {time_us:.0f} of {end_time_us:.0f} µs, {velocity_m_s:.1f} m/s".format(what=what, **number)
    text = "{what}, {done:.0f} of {of:.0f}".format(what=what, **number) + (f", {number['shots']:.0f} shots" if number.get("shots") else "")
    ends = [f"{number[end]:.0f}" for end in ("low_m_s", "high_m_s") if end in number]
    return text + (f", limit {' to '.join(ends)} m/s" if ends else "")


def in_notebook() -> bool:
    """Whether this is the kernel of a notebook."""
    ipython = sys.modules.get("IPython")
    return ipython is not None and hasattr(ipython.get_ipython(), "kernel")


@contextmanager
def shown(progress: bool | Receiver | None, what: str) -> Iterator[Receiver | None]:
    """Receiver of progress while a block runs.

    `progress`: True for a line, False for none, None for a line in a terminal or a notebook, or a function of your own. It is called on your
    thread, ten times a second at most, with numbers by name: of a run `time_us`, `end_time_us`, `velocity_m_s`, `failed_yarns`, `steps`; of a
    study `done`, `of`, `shots`, `low_m_s`, `high_m_s`. What it raises ends the work.
    """
    if callable(progress) or progress is False or not (progress or sys.stderr.isatty() or in_notebook()):
        yield progress if callable(progress) else None
        return
    start = time.monotonic()

    def write(text: str) -> None:
        print("\r" + text[:WIDTH].ljust(WIDTH), end="\r", file=sys.stderr, flush=True)

    try:
        yield lambda at: write(f"{line(what, at)}, {time.monotonic() - start:.0f} s")
    finally:
        if time.monotonic() - start > FIRST:
            write("")
