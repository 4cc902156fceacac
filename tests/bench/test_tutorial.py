"""The tutorial's commands print what it shows, in an empty directory."""

import re
import shlex
from pathlib import Path

import pytest

from shown_output import require_shown

TUTORIAL = (Path(__file__).parents[2] / "docs" / "tutorial.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w*)\n(.*?)```", TUTORIAL, re.DOTALL)


@pytest.mark.slow  # tests/docs/test_quick_start.py has a shorter page
def test_it_shows_what_its_commands_print(enter, capsys):
    """Three commands, each followed by what it prints."""
    done = []
    for (language, code), (_, shown) in zip(BLOCKS[::2], BLOCKS[1::2], strict=True):
        if language == "python":
            exec(code, {})  # noqa: S102 – our own lines
            printed = capsys.readouterr().out
        else:
            assert code.startswith("python -m bench ")
            ended = enter(*shlex.split(code)[3:], output="results/diagnose")
            assert ended.code == 0, ended.err
            printed = ended.out
        require_shown(shown, printed)
        done.append(language)
    assert done == ["sh", "sh", "python"]


def test_the_second_command_is_the_one_that_the_first_prints():
    _, (_, printed), (_, second), *_ = BLOCKS
    assert printed.splitlines()[-1].strip() == second.strip()
