"""Progress of a run or a study: one line that is written over, in a terminal or a notebook."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping

#: Receiver of progress: a mapping of numbers by name, units in the names.
Receiver = Callable[[Mapping[str, float | None]], object]

WIDTH = 79


def is_seen() -> bool:
    """Whether anyone reads lines as they are written."""
    return sys.stderr.isatty() or "ipykernel" in sys.modules


class Line:
    """Line of progress; nothing of it stays when the work is over."""

    def __init__(self, what: str) -> None:
        self.what, self.start, self.shown = what, time.monotonic(), False

    def __call__(self, at: Mapping[str, float | None]) -> None:
        parts = [self.what]
        done, of = at.get("done"), at.get("of")
        if at.get("time_us") is not None:
            parts.append(f"{at['time_us']:.0f} of {at['end_time_us']:.0f} µs, {at['velocity_m_s']:.1f} m/s")
        elif done is not None:
            parts.append(f"{done:.0f} of {of:.0f}")
            if at.get("shots"):
                parts.append(f"{at['shots']:.0f} shots")
            ends = [f"{end:.0f}" for end in (at.get("low_m_s"), at.get("high_m_s")) if end is not None]
            parts.extend(["limit " + " to ".join(ends) + " m/s"] if ends else [])
        parts.append(f"{time.monotonic() - self.start:.0f} s")
        self.shown = True
        print("\r" + ", ".join(parts)[:WIDTH].ljust(WIDTH), end="", file=sys.stderr, flush=True)

    def close(self) -> None:
        """Clears the line."""
        if self.shown:
            print("\r" + " " * WIDTH + "\r", end="", file=sys.stderr, flush=True)


class Progress:
    """Receiver of progress while a block runs.

    `progress`: True for a line, False for none, None for a line where anyone reads it, or a function of your own. It is called on your thread,
    ten times a second at most, with numbers by name: of a run `time_us`, `end_time_us`, `velocity_m_s`, `failed_yarns`, `steps`; of a study
    `done`, `of`, `shots`, `low_m_s`, `high_m_s`. What it raises ends the work.
    """

    def __init__(self, progress: bool | Receiver | None, what: str) -> None:
        wants_line = is_seen() if progress is None else progress is True
        self.line = Line(what) if wants_line else None
        self.receiver: Receiver | None = progress if callable(progress) else self.line

    def __enter__(self) -> Receiver | None:
        return self.receiver

    def __exit__(self, *_: object) -> None:
        if self.line:
            self.line.close()
