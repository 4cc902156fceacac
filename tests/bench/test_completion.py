"""Completion: what may stand at the cursor, and the scripts in real shells."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from bench.command_line.config_dirs import experiment_names
from bench.help.completion import completed, script
from ksmea.plugins import registry

SHELL = """
eval "$({python} -m bench completion bash)"
COMP_WORDS=({words}) COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)) COMP_LINE='{line}' COMP_POINT=${{#COMP_LINE}}
_ksmea_bench
printf '%s\\n' "${{COMPREPLY[@]}}"
"""
ZSH = """
autoload -U compinit && compinit -u -D
compadd() {{ while [[ $1 != -- ]]; do shift; done; shift; print -l -- "$@" }}
eval "$({python} -m bench completion zsh)"
words=({words}) CURRENT=${{#words}}
_ksmea_bench
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "results" / "table3").mkdir(parents=True)
    (tmp_path / "results" / "table3" / "plan.jsonl").touch()
    (tmp_path / "my_optimizer.py").touch()
    (tmp_path / "Prüfstand.csv").touch()
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    "words, expected",
    [
        ("statu", ["status"]),
        ("+exp", ["+experiment="]),
        ("+experiment=tab", [f"+experiment=table{number}" for number in (2, 3, 4, 5, 6, 8)]),
        ("optimi", ["optimizer.", "optimizer="]),
        ("optimizer=de,p", ["optimizer=de,pso"]),
        ("optimizer=lm optimizer.scr", ["optimizer.screening="]),
        ("optimizer=de,lm optimizer.lm.sta", ["optimizer.lm.starts="]),
        ("method.misfit=li", ["method.misfit=likelihood"]),
        ("method.polish=", ["method.polish=false", "method.polish=true"]),
        ("journal=t", ["journal=true"]),
        ("table=aud", ["table=audit"]),
        ("status t", ["<files>", "table3"]),
        ("verify table3 ", []),
        ("new opt", ["optimizer"]),
        ("completion ", ["bash", "zsh"]),
        ("help runo", ["runout"]),
        ("help optimizer nelder", ["nelder_mead"]),
        ("measurement=file measurement.path=", ["<files>"]),
        ("samples=4", []),
        ("--ver", ["--verbose", "--version"]),
        ("--config-dir=nowhere +experiment=tab", []),
    ],
)
def test_what_may_follow(words, expected, folder):
    assert completed(words.split(" ")).splitlines() == expected


def test_all_experiments_and_plugins_are_offered():
    offered = completed(["+experiment="]).splitlines()
    assert offered == [f"+experiment={name}" for name in experiment_names()]
    for group in registry.GROUPS:
        assert completed([f"{group}="]).splitlines() == [
            f"{group}={name}" for name in sorted(registry.registered(group))
        ]


def test_it_loads_nothing_large(tmp_path):
    code = (
        "import sys; from bench import main; main.run(['_complete', '+experiment=table3', 'optimizer.p']);"
        " print([name for name in ('numpy', 'hydra', 'yaml', 'scipy') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path)
    assert done.stdout.splitlines() == ["optimizer.population=", "optimizer.pso.", "[]"]


def in_shell(program, line, folder):
    """Offers of a real shell at the end of a line, its words split as bash splits them at '='."""
    template = SHELL if program == "bash" else ZSH
    words = line.replace("=", " = ") if program == "bash" else line
    quoted = " ".join(f"'{word}'" for word in words.split(" "))
    quoted = quoted.replace("'='  ''", "'='").removesuffix(" ''") if line.endswith("=") else quoted
    source = template.format(python=sys.executable, words=quoted, line=line)
    done = subprocess.run(
        [program, *(["--norc", "--noprofile"] if program == "bash" else ["-f"]), "-c", source],
        capture_output=True, text=True, cwd=folder, timeout=60, check=False, env=os.environ | {"LC_ALL": "C.UTF-8"},
    )  # fmt: skip
    return sorted(done.stdout.split())


@pytest.mark.parametrize("shell", ["bash", "zsh"])
@pytest.mark.parametrize(
    "line, bash, zsh",
    [
        ("python -m bench stat", ["status"], ["status"]),
        ("python -m bench +exp", ["+experiment="], ["+experiment="]),
        ("python -m bench optimizer=de,p", ["de,pso"], ["optimizer=de,pso"]),
        ("python -m bench status tab", ["table3"], ["table3"]),
        ("python -m bench plugins=[my_", ["[my_optimizer.py"], None),
        ("python -m bench measurement=file measurement.path=Pr", ["Prüfstand.csv"], None),
        ("python my_", [], None),
    ],
)
def test_in_a_real_shell(shell, line, bash, zsh, folder):
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    if (expected := bash if shell == "bash" else zsh) is not None:
        line = line.replace("python", sys.executable, 1)
        assert in_shell(shell, line, folder) == expected


def test_the_scripts_are_for_the_console_commands():
    root = Path(__file__).parents[2]
    for shell in ("bash", "zsh"):
        for command in ("ksmea-bench", "ksmea"):
            assert f'{command} = "bench.__main__:main"' in (root / "pyproject.toml").read_text()
            assert command in script([shell]).splitlines()[-1].split()
