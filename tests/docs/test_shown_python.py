"""Python blocks of the pages are Python, and what they import from this project is there. Some are run: by test_readme.py, the
tutorial's and the contest's tests."""

import ast
from importlib import import_module

import pandas as pd
import pytest

from shown_pages import ROOT, blocks, pages, text_of

OURS = ("bench", "ksmea", "measurements", "optimizers", "problems", "surrogates")
SHOWN = [
    pytest.param(code, id=f"{page.relative_to(ROOT)}-{number}")
    for page in pages()
    for number, code in enumerate(blocks(text_of(page), "python"))
]


@pytest.mark.parametrize("code", SHOWN)
def test_what_a_block_imports_is_there(code):
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.ImportFrom) and node.module.split(".")[0] in OURS:
            module = import_module(node.module)
            assert [alias.name for alias in node.names if not hasattr(module, alias.name)] == []
        elif isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.split(".")[0] in OURS:
                    import_module(alias.name)


@pytest.mark.parametrize("code", SHOWN)
def test_functions_of_the_door_are_there(code):
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in ("ksmea", "bench"):
            assert hasattr(import_module(node.value.id), node.attr), f"{node.value.id}.{node.attr}"


def test_the_plot_of_a_sweep_is_made_of_its_runs(tmp_path, monkeypatch):
    """docs/sweeps.md, on runs of two optimisers with two levels of noise."""
    [code] = [each for each in blocks(text_of(ROOT / "docs" / "sweeps.md"), "python") if "savefig" in each]
    rows = [
        {"optimizer": name, "measurement.relative": noise, "kxx_error_pct": sign * noise * (1 + repetition)}
        for name in ("de", "ga")
        for noise in (0.02, 0.1)
        for repetition, sign in enumerate((1, -1, 1))
    ]
    (tmp_path / "results" / "sweep").mkdir(parents=True)
    pd.DataFrame(rows).to_csv(tmp_path / "results" / "sweep" / "runs.csv", index=False)
    monkeypatch.chdir(tmp_path)
    made = {}
    exec(code, made)  # noqa: S102
    assert [line.get_label() for line in made["axes"].get_lines()] == ["de", "ga"]
    assert made["axes"].get_lines()[0].get_ydata() == pytest.approx([0.04, 0.2])
    assert (tmp_path / "sweep.pdf").read_bytes().startswith(b"%PDF")
