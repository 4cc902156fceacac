"""The manners of the command line: the first page, help on whatever has a name, versions, -q and -v, colours."""

import io
import re
import subprocess
import sys
from importlib.metadata import version

import pytest

from bench.command_line.bench_settings import bench_fields
from bench.command_line.config_dirs import experiment_files
from bench.command_line.output_level import has_colours, tell_error
from bench.commands.dispatch import COMMANDS
from bench.help.commands import command_names
from bench.help.help import USAGE
from bench.storage.own_files import ROOT
from ksmea.plugins import registry

ALL = {**registry.GROUPS, **registry.FURTHER}


def test_without_words_it_says_what_to_do_first_and_does_nothing(enter, tmp_path):
    page = enter()
    assert (page.code, page.err) == (0, "") and list(tmp_path.iterdir()) == []
    for words in ("+experiment=table3", "+experiment=diagnose problem=rotor", "new optimizer", "help"):
        assert f"python -m bench {words}" in page.out
    assert len(page.out.splitlines()) < 15


def test_what_the_first_page_says_is_accepted(enter):
    """Up to the files, which the reader has and this test has not."""
    page = enter().out.replace("\\\n", " ")
    for line in re.findall(r"python -m bench (\+experiment=\S+)(?: |$)(.*)", page):
        ended = enter(*" ".join(line).split(), "samples=no")
        assert ended.err.startswith("error: samples: expected a whole number"), ended.err


@pytest.mark.parametrize("words", [["--version"], ["version"], ["+experiment=table3", "--version"]])
def test_the_version_is_the_projects_own(words, enter):
    printed = enter(*words).out
    assert printed.startswith(f"ksmea-bench {version('ksmea-bench')} (")
    assert f"Python {sys.version_info.major}.{sys.version_info.minor}" in printed
    assert ("commit" in printed) == (ROOT / ".git").exists()


@pytest.mark.parametrize("name", [*COMMANDS, "help", "completion"])
def test_every_command_has_its_help_however_it_is_asked_for(name, enter):
    pages = [enter(*words) for words in (["help", name], [name, "--help"], [name, "-h"], [name, "x", "-h"])]
    assert {(page.code, page.err) for page in pages} == {(0, "")}
    assert len({page.out for page in pages}) == 1
    assert pages[0].out.startswith(f"python -m bench {name}") and len(pages[0].out) > 150
    assert name in command_names(USAGE)


@pytest.mark.parametrize("name", experiment_files())
def test_every_experiment_says_what_it_answers_and_what_it_costs(name, enter):
    page = enter("help", name)
    assert page.code == 0 and page.out.startswith(f"+experiment={name}\n  ")
    answers = page.out.split("\n\n")[0].splitlines()[1:]
    assert len(" ".join(answers)) > 60
    assert f"python -m bench +experiment={name}" in page.out
    assert "includes:" in page.out or ("cost:" in page.out and f"results/{name}/" in page.out)
    assert enter(f"+experiment={name}", "-h").out in page.out  # a study or report may have the same name


def test_an_experiments_page_counts_its_runs(enter):
    """Table 3: 4 sample sizes, 20 repetitions; the contest: 14 methods, 5 families of 15 instances, 2 repetitions."""
    assert "80 runs (4 cells × 20 repetitions)" in enter("help", "table3").out
    assert "2100 runs (1050 cells × 2 repetitions)" in enter("help", "contest").out
    assert "problem.instance: 0, 1, 2" in enter("help", "contest").out


@pytest.mark.parametrize("group, name", [(group, name) for group in ALL for name in registry.registered(group)])
def test_every_plugin_is_found_by_its_name_alone(group, name, enter):
    page = enter("help", name)
    [head] = [line for line in page.out.splitlines() if line.startswith(f"{group}={name}: ")]
    assert (
        page.code == 0
        and len(head) > len(f"{group}={name}: ") + 30
        and f"{name}(" not in head.partition(":")[2].lower()
    )


@pytest.mark.parametrize(
    "name, said",
    [
        *((name, f"{name}=") for name, field in bench_fields().items() if field.metadata),
        ("samples", "samples=100  initial samples of a surrogate (at least 1)"),
        ("timeout", "timeout=null  s per run; null: none (above 0)"),
        ("journal", "journal=false  "),
        ("output", "output=results/${name}  "),
        ("share", "share=[]  "),
    ],
)
def test_every_setting_of_the_bench_has_its_help(name, said, enter):
    [line] = [line for line in enter("help", name).out.splitlines() if line.endswith("(of the whole experiment)")]
    assert line.startswith(said)


@pytest.mark.parametrize("words", ["optimizer.population", "optimizer.de.population", "population"])
def test_a_setting_of_plugins(words, enter):
    page = enter("help", words).out
    assert "optimizer=de:\n  optimizer.population=100  members of the population (at least 5)" in page
    assert ("optimizer=ga:" in page) == (words != "optimizer.de.population")


def test_limits_of_an_effect_are_those_on_the_problem_that_is_named(enter):
    here = enter("help", "effect", "added_mass").out
    there = enter("help", "effect", "added_mass", "problem=rk4").out
    own = enter("help", "added_mass", "problem=three_disk", "problem.mesh=21").out
    assert "(problem=three_disk)" in here and "(problem=rk4)" in there and "(problem=three_disk problem.mesh=21)" in own
    assert [line for line in here.splitlines() if "unknown" in line] != [
        line for line in there.splitlines() if "unknown" in line
    ]
    assert enter("help", "added_mass", "problem=rk5").err.startswith("error: problem=rk5: expected a problem that")


# -- -q, -v, colours --


def test_quiet_shows_errors_alone(enter, cheapest):
    done = enter("-q", *cheapest, "repetitions=1")
    assert (done.code, done.out, done.err) == (0, "", "") and (done.output / "run.csv").is_file()
    assert enter("status", "run", "--quiet").out == ""
    assert enter("--quiet", "samples=no").err.startswith("error: samples")
    assert enter("status", "run").out != ""  # the next command is not quiet


def test_verbose_tells_each_run_and_shows_tracebacks(enter, cheapest):
    done = enter(*cheapest, "repetitions=2", "-v")
    told = [line for line in done.err.splitlines() if line.startswith("run ")]
    assert done.code == 0 and len(told) == 2 and all(" done after " in line for line in told)
    wrong = enter("--verbose", "samples=no")
    assert "Traceback (most recent call last)" in wrong.err and wrong.err.splitlines()[-1].startswith("error: samples")


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_colours_are_for_terminals_that_want_them(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)
    assert has_colours(Terminal()) and not has_colours(io.StringIO())
    monkeypatch.setattr(sys, "stderr", Terminal())
    tell_error("no such thing")
    assert sys.stderr.getvalue() == "\x1b[1;31merror:\x1b[0m no such thing\n"
    monkeypatch.setenv("NO_COLOR", "1")
    assert not has_colours(Terminal())
    monkeypatch.delenv("NO_COLOR")
    monkeypatch.setenv("TERM", "dumb")
    assert not has_colours(Terminal())


def test_the_package_is_a_command_too(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "ksmea", "--version"], capture_output=True, text=True, cwd=tmp_path, check=True
    )
    assert done.stdout.startswith("ksmea-bench ")
