"""The Python lines of the pages do what they say, and the README has what continuous integration reads from it."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
MARKED = {  # what .ci/run and the first job of a reader take from the README, word by word
    "main job": "python -m bench +experiment=table3",
    "test command": "python -m pytest -q -n auto --maxprocesses 4",
}
MOST_LINES = 120
SHORTER = {  # the page's words, and what takes less time; tests/docs/test_quick_start.py diagnoses its run-up in full
    "repetitions=3": "repetitions=1, samples=40",
    "diagnose(rotor, data)": 'diagnose(rotor, data, effects=["runout", "mass"], screening=512, starts=3)',
}


def block(page):
    """The first Python block of a page."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    return re.search(r"```python\n(.*?)```", text, re.DOTALL)[1]


def test_the_readme_is_short():
    assert len(README.splitlines()) <= MOST_LINES


def test_the_marked_commands_stand_between_their_markers():
    for mark, last in MARKED.items():
        [between] = re.findall(rf"<!-- {mark} -->\n```sh\n(.*)\n```\n<!-- end -->", README)
        assert between.startswith("python3 -m venv .venv && ") and between.endswith(last)


def test_from_python(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    shutil.copy(ROOT / "docs" / "examples" / "rotor.yaml", "my_rotor.yaml")
    shutil.copy(ROOT / "docs" / "examples" / "run_up.csv", "run_up.csv")
    names = {}
    lines = block("python.md")
    for shown, shorter in SHORTER.items():
        assert shown in lines
        lines = lines.replace(shown, shorter)
    exec(lines, names)  # noqa: S102 – our own lines
    printed = capsys.readouterr().out
    assert "kxx = " in printed and "Verdict: " in printed
    assert Path("found.json").is_file() and Path("found.png").read_bytes()[:4] == b"\x89PNG"
    assert names["table3"].failed == 0 and names["rotor"].name == "rotor"


def test_bring_a_plugin():
    names = {"__name__": "uniform_search"}
    exec(block("plugins.md"), names)  # noqa: S102
    objective = names["Objective"](2, lambda u: u - 0.5)
    found = names["UniformSearch"](points=500).minimize(objective, np.random.default_rng(0))
    assert found.evaluations == 500 and found.value < 0.01
    with pytest.raises(ValueError, match="points: expected a whole number"):
        names["UniformSearch"](points="many")
