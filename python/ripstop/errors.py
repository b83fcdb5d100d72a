"""Exceptions. Their text is that of the command line: where, expected, found, help."""

from __future__ import annotations

from typing import Any

from ._ripstop import CaseError, DeviceError, RunError

__all__ = ["CaseError", "DeviceError", "Interrupted", "RunError", "failed"]


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a run or a study.

    `result`: the run up to that moment; None of a study, whose rows so far lie in `folder`.
    """

    def __init__(self, text: str, result: Any = None, folder: str | None = None) -> None:
        super().__init__(text)
        self.result, self.folder = result, folder


def failed(failure: BaseException, result: Any = None, text: str = "interrupted", folder: str | None = None) -> BaseException:
    """Exception to raise for a failure, with what there is of a result."""
    if isinstance(failure, KeyboardInterrupt):
        return Interrupted(text, result, folder)
    if isinstance(failure, RunError):
        failure.result = result
    return failure
