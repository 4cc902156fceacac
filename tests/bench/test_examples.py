"""The packages of examples/: their own tests, their registration, and new ones that are made of them."""

import os
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from bench import main
from bench.commands.new import FIRST_RUN
from ksmea.plugins import registry
from ksmea.plugins.files import plugins_of_file
from outside_package import plain_files
from tiers import mostly_slow

EXAMPLES = Path(__file__).parents[2] / "examples"
EXAMPLE_GROUPS = sorted(path.name for path in EXAMPLES.iterdir() if (path / "pyproject.toml").is_file())
CHEAP = ["repetitions=1", "study.intervals=none", "workers=1"]


def run_tests(*folders):
    """The tests in folders of packages that are installed, as far as Python can tell."""
    paths = [*map(str, folders), *filter(None, [os.environ.get("PYTHONPATH"), str(EXAMPLES.parent)])]
    options = ["-q", "-p", "no:cacheprovider", "-c", os.devnull, "--import-mode=importlib"]
    return subprocess.run(
        [sys.executable, "-m", "pytest", *options, *map(str, folders)],
        env=os.environ | {"PYTHONPATH": os.pathsep.join(paths), "PYTHONDONTWRITEBYTECODE": "1"},
        check=False,
        capture_output=True,
        text=True,
    )


def test_the_tests_of_all_examples_pass():
    done = run_tests(*(EXAMPLES / group for group in EXAMPLE_GROUPS))
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("group", EXAMPLE_GROUPS)
def test_an_entry_point_names_the_plugin_as_its_file_does(group):
    project = tomllib.loads((EXAMPLES / group / "pyproject.toml").read_text())
    groups = project["project"]["entry-points"]
    [(name, value)] = groups[(registry.GROUPS | registry.FURTHER)[group]].items()
    module, _, plugin = value.partition(":")
    with plain_files(EXAMPLES):
        [found] = plugins_of_file(EXAMPLES / group / f"{module}.py")
        assert (found.group, found.name, found.plugin.__name__) == (group, name, plugin)
    assert project["tool"]["hatch"]["build"]["targets"]["wheel"]["only-include"] == [f"{module}.py"]


def test_there_is_one_of_every_kind_that_can_be_made():
    assert EXAMPLE_GROUPS == sorted(FIRST_RUN)


@pytest.mark.parametrize("group", mostly_slow(EXAMPLE_GROUPS, but=["optimizer", "problem"]))
def test_a_new_file_runs_by_the_command_that_is_printed(group, tmp_path, enter):
    new = enter("new", group, "my_own", "--file")
    assert new.code == 0
    written, command = new.out.splitlines()
    assert written == "written: my_own.py" and [path.name for path in tmp_path.iterdir()] == ["my_own.py"]
    _, _, words = command.partition("python -m bench ")
    with plain_files(tmp_path):
        ended = enter(*shlex.split(words), *CHEAP)
    assert (ended.code, ended.err) == (0, "")


def test_a_new_package_has_tests_that_pass(tmp_path, enter):
    """Of one kind: the tests of all of them pass above, under other names."""
    assert enter("new", "optimizer", "my_own").code == 0
    done = run_tests(tmp_path / "my_own")
    assert done.returncode == 0, done.stdout
    text = "".join(path.read_text() for path in (tmp_path / "my_own").glob("*.*"))
    assert 'my_own = "my_own:MyOwn"' in text and "compass_search" not in text.lower().replace("-", "_")


@pytest.mark.parametrize(
    "words, expected",
    [
        (["optimizer"], "new: expected a kind of plugin and a name, as new optimizer my_search, got 1 words"),
        (["optimiser", "mine"], "unknown kind of plugin: 'optimiser'; did you mean 'optimizer'?"),
        (["optimizer", "My-Search"], "new: expected a name in snake case, as my_search, got My-Search"),
        (["optimizer", "de"], "new: optimizer=de is there already, from ksmea-bench "),
        (["optimizer", "numpy"], "new: there is a Python module numpy already"),
        (["effect", "taken"], "new: expected no taken/pyproject.toml yet, found one"),
    ],
)
def test_what_cannot_be_made_is_told_in_one_line_and_nothing_is_written(words, expected, tmp_path, enter):
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "pyproject.toml").touch()
    ended = enter("new", *words)
    assert (ended.code, ended.out) == (main.BAD_INPUT, "")
    [line] = ended.err.splitlines()
    assert line.startswith(f"error: {expected}")
    assert [path.name for path in tmp_path.rglob("*")] == ["taken", "pyproject.toml"]
