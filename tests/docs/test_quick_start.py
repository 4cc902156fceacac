"""The quick start's commands on a measured run-up print what it shows, and the verdict that it tells of."""

import shutil
import sys

import pytest
from hydra.core.global_hydra import GlobalHydra

from bench import main
from shown_output import require_shown
from shown_pages import DOCS, FENCE, commands, text_of

PAGE = DOCS / "quick_start.md"


@pytest.fixture
def printed(tmp_path, monkeypatch, capsys):
    """Output of a command of the page, in a directory with the examples."""

    def call(experiment):
        shutil.copytree(DOCS / "examples", tmp_path / "docs" / "examples", dirs_exist_ok=True)
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", ["bench"])
        monkeypatch.setenv("HYDRA_FULL_ERROR", "1")
        [words] = [command.words[3:] for command in commands(PAGE) if f"+experiment={experiment}" in command.words]
        try:
            assert main.run(list(words)) == 0
        finally:
            GlobalHydra.instance().clear()
        return capsys.readouterr().out

    return call


def test_identify_prints_what_is_shown(printed):
    shown = [content for language, content in FENCE.findall(text_of(PAGE)) if content.startswith("rotor, run_up.csv")]
    require_shown(*shown, printed("identify"))


def test_diagnose_comes_to_the_verdict_that_is_told(printed):
    assert "Verdict: adequate" in printed("diagnose")
