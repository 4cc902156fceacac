"""Mutated command lines: planned, done or refused in one line; never a traceback, never for ever. Experiments are planned and not run."""

import os
import time

import pytest
from hydra.core.global_hydra import GlobalHydra

from bench import main
from bench.jobs import offers
from mutated_words import mutated

N_LINE = int(os.environ.get("KSMEA_MUTATED", "40"))  # CONTRIBUTING.md has the command for 2000


@pytest.mark.parametrize("block", range(4))
def test_mutated_command_lines(block, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["bench"])
    monkeypatch.setattr(offers, "unfinished", lambda runs, finished: [])  # Hydra imports its own copy of `dealt`
    for seed in range(block * N_LINE // 4, (block + 1) * N_LINE // 4):
        started = time.monotonic()
        try:
            code = main.run(words := mutated(seed))
        finally:
            GlobalHydra.instance().clear()
        printed = capsys.readouterr()
        assert code in (0, 1, 2), (seed, printed.err)
        if not {"-v", "--verbose"}.isdisjoint(words):  # which shows the traceback before the line
            printed = printed._replace(err=printed.err[printed.err.rfind("error: ") :])
        assert "Traceback" not in printed.err, seed
        if code == 2:
            assert printed.err.startswith("error: ") and printed.err.count("\n") == 1, (seed, printed.err)
        assert time.monotonic() - started < 60, seed
