"""Ctrl-C before anything runs: a real signal at the moment in which a module is imported, whichever stage that is."""

import subprocess
import sys

import pytest

from bench import main

AT = """
import os, runpy, signal, sys

class Signal:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            sys.meta_path.remove(self)
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Signal())
sys.argv = ["bench", *{words!r}]
runpy.run_module("bench", run_name="__main__", alter_sys=True)
"""
RUN = ["+experiment=table3", "repetitions=1", "samples=0"]


@pytest.mark.parametrize(
    "module, words",
    [
        ("bench.storage.shadowed_packages", RUN),  # the first import of all
        ("bench.main", RUN),
        ("ksmea.plugins.names", RUN),
        ("hydra", RUN),  # reading the words
        ("problems.three_disk", RUN),  # composing
        ("bench.jobs.offers", RUN),  # planning
        ("bench.help.plugins", ["help", "lm"]),
        ("bench.commands.status", ["status", "x"]),
    ],
)
def test_one_line_and_130(module, words, tmp_path, heeds_sigint):
    source = AT.format(module=module, words=words)
    done = subprocess.run(
        [sys.executable, "-c", source], capture_output=True, text=True, cwd=tmp_path, timeout=60, check=False
    )
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr.startswith("interrupted: ") and done.stderr.count("\n") == 1, done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("last", [UnboundLocalError("f"), main.SettingError("samples: expected …"), OSError(5, "lost")])
def test_an_error_that_comes_of_the_interrupt_is_the_interrupt(last, monkeypatch, capsys):
    """Hydra raises an UnboundLocalError where it is interrupted while it opens a file."""

    def interrupted(words):
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt:
            raise last  # noqa: B904 – as libraries do

    monkeypatch.setattr(main, "run_command", interrupted)
    assert main.run(["status", "x"]) == 130
    assert capsys.readouterr().err.startswith("interrupted: finished runs are kept")


def test_another_error_stays_one(monkeypatch):
    def broken(words):
        raise ZeroDivisionError

    monkeypatch.setattr(main, "run_command", broken)
    with pytest.raises(ZeroDivisionError):
        main.run(["status", "x"])
