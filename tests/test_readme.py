"""The README's Python lines do what they say."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def block(heading):
    section = README.split(f"## {heading}\n")[1].split("\n## ")[0]
    return re.search(r"```python\n(.*?)```", section, re.DOTALL)[1]


def test_from_python(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    shutil.copy(ROOT / "docs" / "examples" / "rotor.yaml", "my_rotor.yaml")
    shutil.copy(ROOT / "docs" / "examples" / "run_up.csv", "run_up.csv")
    names = {}
    exec(block("From Python").replace("repetitions=3", "repetitions=1, samples=40"), names)  # noqa: S102 – our own lines
    printed = capsys.readouterr().out
    assert "kxx = " in printed and "Verdict: " in printed
    assert Path("found.json").is_file() and Path("found.png").read_bytes()[:4] == b"\x89PNG"
    assert names["table3"].failed == 0 and names["rotor"].name == "rotor"


def test_bring_a_plugin():
    names = {"__name__": "uniform_search"}
    exec(block("Bring a plugin"), names)  # noqa: S102
    objective = names["Objective"](2, lambda u: u - 0.5)
    found = names["UniformSearch"](points=500).minimize(objective, np.random.default_rng(0))
    assert found.evaluations == 500 and found.value < 0.01
    with pytest.raises(ValueError, match="points: expected a whole number"):
        names["UniformSearch"](points="many")
