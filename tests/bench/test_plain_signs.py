"""Streams that lack characters of what is printed: a Windows pipe (cp1252), ASCII and Latin-1. Nothing fails for its characters."""

import io
import os
import subprocess
import sys
from pathlib import Path

import pytest

from bench import main
from bench.command_line.config_dirs import experiment_names
from bench.command_line.plain_signs import SIGNS, in_plain_signs
from bench.commands.dispatch import COMMANDS
from bench.help.glossary import entries
from ksmea.plugins.names import FURTHER, GROUPS, registered
from tiers import mostly_slow

EXAMPLES = Path(__file__).resolve().parents[2] / "docs" / "examples"
ENCODINGS = ("cp1252", "ascii", "latin-1")
NOISY = ["measurement.kind=complex", "measurement.relative=0.05", "workers=1", "repetitions=1"]
FEW = ["problem.sensors=[0.1,0.5]", "problem.n_speed=20"]
STUDIES = {  # each study in a few seconds
    "identify": [
        "+experiment=identify",
        "measurement=synthetic",
        *NOISY,
        *FEW,
        "optimizer.screening=100",
        "optimizer.starts=1",
    ],
    "identify_in_detail": ["study=identify_in_detail", *NOISY, *FEW, "method=direct", "optimizer=lm"],
    "diagnose": ["+experiment=diagnose", *NOISY, *FEW, "measurement.hidden=[runout]", "study.effects=[runout,mass]"],
    "identifiability": ["+experiment=identifiability", *NOISY, *FEW, "study.variations=[]"],
    "locate": ["+experiment=locate", *NOISY, *FEW, "study.positions=[0.2,0.6]", "study.kinds=[force]"],
    "plan": ["+experiment=plan", *NOISY, *FEW],
    "balance": ["+experiment=balance", "measurement=campaign", f"measurement.path={EXAMPLES / 'balancing.yaml'}"],
    "table5": ["+experiment=table5"],
    "table3": ["+experiment=table3", "surrogate=none", "samples=25", "optimizer.generations=1", *NOISY[2:]],
}


@pytest.fixture
def printed(monkeypatch):
    """Output of a command on streams of an encoding, and its exit code."""

    def call(encoding, *words):
        out, err = (io.TextIOWrapper(io.BytesIO(), encoding=encoding, write_through=True) for _ in range(2))
        with monkeypatch.context() as patch:
            patch.setattr(sys, "stdout", out)
            patch.setattr(sys, "stderr", err)
            code = main.run(list(words))
        return code, *(stream.buffer.getvalue().decode(encoding) for stream in (out, err))

    return call


@pytest.mark.parametrize("study", mostly_slow(STUDIES, but=["identify", "table3", "table5"]))
def test_tables_of_a_study(study, enter, printed):
    ended = enter(*STUDIES[study], "output=results")
    assert ended.code == 0, ended.err
    explain = [] if study == "table5" else [["explain", "", "results"]]  # a table of settings has no runs
    for encoding in ENCODINGS:
        for words in (["collect", "results"], ["status", "results"], *explain):
            code, out, err = printed(encoding, *words)
            assert (code, err) == (0, ""), (encoding, words)
            assert len(out.splitlines()) > 1


def topics():
    yield []
    yield from ([name] for name in (*COMMANDS, *experiment_names(), *GROUPS))
    yield from ([group, name] for group in (*GROUPS, *FURTHER) for name in registered(group))
    yield from ([term] for term in sorted({name for entry in entries() for name in entry.names}))


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_help(encoding, printed):
    """Of every command, experiment, plugin, effect and term of the glossary."""
    for words in topics():
        code, out, err = printed(encoding, "help", *words)
        assert (code, err) == (0, ""), words
        assert out


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("word", ["µ→χ²=1", "problem.file=Läufer\udce4→.yaml", "samples=−3", "output=Größe≤3"])
def test_errors(encoding, word, printed):
    code, out, err = printed(encoding, "problem=rotor", word, "problem.mesh=−3")
    assert code == 2 and out == "" and err.startswith("error: ") and err.count("\n") == 1


@pytest.mark.parametrize("encoding", mostly_slow(ENCODINGS, but=["ascii"]))
def test_a_command_in_a_process_of_its_own(encoding, tmp_path):
    environment = os.environ | {"PYTHONIOENCODING": encoding}
    words = [sys.executable, "-m", "bench", "help", "plan"]
    done = subprocess.run(words, check=False, cwd=tmp_path, env=environment, capture_output=True, encoding=encoding)
    assert (done.returncode, done.stderr) == (0, "") and "plan" in done.stdout


@pytest.mark.slow
def test_signs_in_plain_ones():
    """The substitute of a sign is ASCII, and means as much."""
    assert all(plain.isascii() and plain for plain in SIGNS.values())
    assert in_plain_signs("ΔBIC ≤ 6, χ² → 10⁻³, 2½°, Λ, é") == "DeltaBIC <= 6, chi^2 -> 10^-3, 2 1/2 deg, Lambda, e"
    assert all(in_plain_signs(chr(code)).isascii() for code in range(0x110000))
