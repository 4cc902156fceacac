"""The types of the source, read by mypy: they hold, they say when a call is wrong, and nothing is waved through."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("mypy", reason="mypy reads the types; install the extra `test`")
pytestmark = pytest.mark.xdist_group("mypy")  # one after the other: the second finds what the first has read
ROOT = Path(__file__).parents[1]
IGNORED = 0  # comments that keep mypy from a line; one more wants a reason
WRONG = """\
import ksmea

measurement = ksmea.read_measurement("run_up.csv")
found = ksmea.identify("measurement", measurement)
found.intervalls
"""


def checked(*options: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "mypy", "--config-file", "pyproject.toml", *options]
    return subprocess.run(command, check=False, capture_output=True, text=True, cwd=ROOT)


@pytest.mark.slow
def test_the_types_hold():
    done = checked()
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.slow
def test_a_wrong_call_is_reported(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(WRONG)
    done = checked(str(script))
    assert done.returncode == 1
    lines = [int(found[1]) for found in re.finditer(r"script\.py:(\d+): error", done.stdout)]
    assert set(lines) >= {4, 5}, done.stdout


def test_no_line_is_waved_through():
    names = ["ksmea", "problems", "surrogates", "optimizers", "measurements", "bench"]
    sources = [path.read_text(encoding="utf-8") for name in names for path in (ROOT / name).rglob("*.py")]
    assert sum(len(re.findall(r"#\s*type:\s*ignore", source)) for source in sources) == IGNORED
