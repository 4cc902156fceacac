"""The page on a real rig: its commands print what it shows, where the published data are; two minutes of a core each."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from shown_pages import DOCS, blocks, text_of

PAGE = DOCS / "rk4.md"
DATA = Path(os.environ.get("KSMEA_DATA", DOCS.parents[1] / "shared" / "data")) / "rk4" / "runup_bode_first_critical.csv"
LONG = "KSMEA_LONG"  # environment variable: what takes minutes of a core is run too; tests/diagnosis/test_variable_projection.py is quick
ROW = re.compile(r"^ *(\w+) {2,}(.+?) {2,}(-?[\d.]+) {2,}\S+ {2,}(.+)$")  # effect, location, ΔBIC, p, size
pytestmark = [
    pytest.mark.skipif(not DATA.is_file(), reason=f"{DATA} is not here: public data that are not committed"),
    pytest.mark.skipif(LONG not in os.environ, reason=f"minutes of a core; {LONG}=1 runs it"),
]


def shown():
    """Each command of the page with what it shows below it."""
    found = []
    for text in blocks(text_of(PAGE), ""):
        first, *lines = text.replace("\\\n", " ").splitlines()
        if first.startswith("$ "):
            found.append(pytest.param(shlex.split(first.removeprefix("$ "))[3:], lines, id=first[-40:]))
    return found


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A directory with the files that the page's lines of Python write."""
    folder = tmp_path_factory.mktemp("rk4")
    shutil.copy(DATA, folder / DATA.name)
    [code] = blocks(text_of(PAGE), "python")
    subprocess.run([sys.executable, "-c", code], cwd=folder, check=True)
    return folder


@pytest.mark.parametrize(("words", "lines"), shown())
def test_the_page_shows_what_its_commands_print(words, lines, place, shell):
    """Names, places, sizes, notes and the verdict to the letter; ΔBIC to 1, far less than between maxima."""
    ended = shell(*words, "workers=1", cwd=place, timeout=3000)
    assert ended.code == 0, ended.err
    printed = rows(ended.out.splitlines())
    assert rows(lines)
    for name, (location, evidence, size) in rows(lines).items():
        assert printed[name][::2] == (location, size), (name, printed[name])
        assert abs(printed[name][1] - evidence) < 1.0, (name, printed[name])
    for line in lines:
        if line.startswith(("Verdict", "Note")):
            assert line in ended.out


def rows(lines):
    found = (ROW.match(line) for line in lines)
    return {match[1]: (match[2], float(match[3]), match[4]) for match in found if match}
