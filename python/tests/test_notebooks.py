"""Notebooks: all cells run, from a kernel of their own, with fewer samples than a reader takes.

What can turn these red: a cell that raises, a notebook with outputs stored in it, one that says what its own numbers do not show.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

FOLDER = Path(__file__).parent.parent / "notebooks"
#: What the outputs of each hold, as a pattern.
SHOWN = {
    "first-shot": r"PERFORATED: leaves at 2\d\d m/s.*did you mean \"mass_g\"",
    "v50": r"as published: V50 \d+",
    "which-parameters-matter": r"16 limits, 16 computed",
    "calibration": r"The data do not fix /fabric/crossover/compression/a_mm between 0.02 and 0.25",
}


def texts(output: Any) -> str:
    return str(output.get("text", "")) + "".join(str(text) for kind, text in output.get("data", {}).items() if kind.startswith("text/"))


def test_there_are_four_without_outputs() -> None:
    files = sorted(FOLDER.glob("*.ipynb"))
    assert {file.stem for file in files} == SHOWN.keys()
    for file in files:
        notebook = nbformat.read(file, as_version=4)
        nbformat.validate(notebook)
        assert file.stat().st_size < 20_000 and not any(cell.get("outputs") for cell in notebook.cells)


@pytest.mark.parametrize("name", SHOWN)
def test_notebook_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RIPSTOP_SAMPLES", "2")
    monkeypatch.setenv("RIPSTOP_REALISATIONS", "2")
    notebook = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)
    NotebookClient(notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    assert re.search(SHOWN[name], "\n".join(map(texts, outputs)), re.S)
    figures = sum("image/png" in output.get("data", {}) for output in outputs)
    assert figures >= {"first-shot": 3, "v50": 2, "which-parameters-matter": 3, "calibration": 2}[name]
