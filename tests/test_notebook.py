"""The example notebook does what it says, in an empty directory, in at most forty lines."""

import re
from pathlib import Path

import nbformat
import pytest

NOTEBOOK = Path(__file__).parents[1] / "docs" / "examples" / "identification.ipynb"
MAX_LINES = 40
NUMBER = r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?"


@pytest.fixture(scope="module")
def notebook():
    return nbformat.read(NOTEBOOK, as_version=4)


def code(notebook):
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def test_it_is_short(notebook):
    lines = [line for cell in code(notebook) for line in cell.source.splitlines() if line.strip()]
    assert len(lines) <= MAX_LINES
    assert "__main__" not in "".join(lines)


# tests that take this fixture are slow; `.ci/run` executes the notebook's lines from the wheel
@pytest.fixture(scope="module")
def executed(tmp_path_factory):
    nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed")
    fresh = nbformat.read(NOTEBOOK, as_version=4)
    for cell in code(fresh):
        cell.outputs = []
    folder = str(tmp_path_factory.mktemp("notebook"))
    return nbclient.NotebookClient(fresh, timeout=300, resources={"metadata": {"path": folder}}).execute()


def printed(cell):
    """Output of a cell, but for the progress that it shows on the error stream."""
    return "".join(output.get("text", "") for output in cell.outputs if output.get("name") == "stdout")


@pytest.mark.slow
def test_it_runs_and_finds_what_is_hidden(executed):
    texts = [printed(cell) for cell in code(executed)]
    assert any("Verdict: named – unequal_bearings (stiffness of bearing 2)" in text for text in texts)
    assert "unequal_bearings (stiffness of bearing 2): stiffness_difference_x = " in texts[-1]
    assert any("the model does not fit: its residuals are not noise" in text for text in texts)
    assert all(output.output_type != "error" for cell in code(executed) for output in cell.outputs)


@pytest.mark.slow
def test_figures_and_tables_are_shown(executed):
    output_types = {
        output_type for cell in code(executed) for output in cell.outputs for output_type in output.get("data", {})
    }
    assert {"image/png", "text/html"} <= output_types


@pytest.mark.slow
def test_what_it_shows_in_the_repository_is_what_it_does(notebook, executed):
    """Words are equal, and numbers to 2 %.

    Searches end in their sixth digit otherwise on another kind of processor.
    """
    for stored, now in zip(code(notebook), code(executed)):
        assert re.sub(NUMBER, "", printed(stored)).split() == re.sub(NUMBER, "", printed(now)).split()
        numbers = ([float(found) for found in re.findall(NUMBER, printed(cell))] for cell in (stored, now))
        assert next(numbers) == pytest.approx(next(numbers), rel=0.02, abs=1e-6)
