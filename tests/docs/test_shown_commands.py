"""Every command that README and docs show is accepted: experiments are planned, help is printed, files are there.

The plan refuses names, settings and files that do not exist; nothing is run here. A command that is an experiment's name alone is
planned by tests/bench/test_experiments.py. What quick start and tutorial print is held by tests of their own.
"""

import copy
import re
import shutil
import sys
from itertools import pairwise
from pathlib import Path

import pytest
from hydra import initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.types import RunMode

from bench import main
from bench.command_line.overrides import for_some_plugins
from bench.commands.dispatch import COMMANDS
from bench.commands.draw import OPTIONS, OUTPUT, PROBLEM, VALUES
from bench.help.help import help_text
from bench.plan.experiment import Experiment
from bench.storage.own_files import CONF, REFERENCE
from ksmea.plugins import registry
from ksmea.settings.settings import own_fields
from outside_package import plain_files
from shown_pages import DOCS, INLINE, ROOT, blocks, commands, pages, text_of

NOT_TRIED = {  # first words → why
    "python3 -m venv": "continuous integration does what the README installs",
    "pip install": "the same",
    ". ": "the shell's own",
    "ruff": "a tool of its own",
    "lint-imports": "the same",
    "python -m mypy": "the same",
    "python -m pytest": "these tests",
    "python docs/examples/made_files.py": "tests/bench/test_own_data_page.py runs it",
    "python -m bench import": "the same",
    "python -m bench import rotor": "test_import_rotor_page.py runs it",
    "python -m bench export measurement": "tests/bench/test_own_data_page.py runs it",
    "python -m benchmarks": "tests/benchmarks does",
    "eval ": "the shell's own; tests/bench/test_completion.py",
    "python -m sphinx": "the site is built by test_site.py",
    "python -m bench +experiment=sweep hydra/launcher=joblib": "the launcher is a package of its own",
}
STANDS_FOR = {  # what pages leave to the reader
    "problem=…": "problem=three_disk",
    "KEY": "0123456789abcdef",
    "NAME": "table3",
    "+experiment=NAME": "+experiment=table3",
    "FOLDER": "results/table3",
    "SAMPLES": "15",
}
LEAVES_CELLS = ("repetitions", "seed", "output", "workers")  # settings that plan the same cells
MEASURED_ELSEWHERE = "rk4/campaign.yaml"  # made by docs/examples/rk4_weights.py from published data


def shown():
    """Each command once, without its placeholders, in the order of the pages."""
    found = {}
    for page in pages():
        for command in commands(page):
            words = tuple(STANDS_FOR.get(word, word) for word in command.words if not re.match(r"[A-Z_]+=", word))
            words = tuple(word.removeprefix(".venv/bin/") for word in words)
            found.setdefault(words, str(command))
    return [pytest.param(list(words), id=name) for words, name in found.items() if words]


def not_tried(words):
    return any(" ".join(words).startswith(start) for start in NOT_TRIED)


COMMAND_LINES = [param for param in shown() if not not_tried(param.values[0])]
BENCH = [param for param in COMMAND_LINES if param.values[0][:3] == ["python", "-m", "bench"]]
OTHERS = [param for param in COMMAND_LINES if param not in BENCH]
OWN_COMMANDS = [param for param in BENCH if param.values[0][3:4] and param.values[0][3] in COMMANDS]
HELP = [param for param in BENCH if param.values[0][3:4] == ["help"]]
EXPERIMENTS = [param for param in BENCH if param not in OWN_COMMANDS and param not in HELP and param.values[0][3:]]


@pytest.fixture(scope="module")
def workspace(tmp_path_factory):
    """A reader's working directory: the files that the pages name, most of them copies of docs/examples."""
    place = tmp_path_factory.mktemp("reader")
    examples = DOCS / "examples"
    (place / "docs").mkdir()
    (place / "docs" / "examples").symlink_to(examples)
    (place / "fleet").mkdir()
    for name in ("rotor.yaml", "my_rotor.yaml", "pump.yaml", "fleet/fan.yaml"):
        shutil.copy(examples / "rotor.yaml", place / name)
    for name in ("run_up.csv", "bare.csv", "trial.csv", "fleet/fan.csv", "fleet/pump.csv"):
        shutil.copy(examples / "run_up.csv", place / name)
    shutil.copy(examples / "extended.yaml", place / "extended.yaml")
    run_up = (examples / "run_up.csv").read_text()
    lines = run_up.splitlines(keepends=True)
    third = [line + line.replace(",0.1,x,", ",0.5,x,") if ",0.1,x," in line else line for line in lines]
    (place / "run.csv").write_text("".join(third))  # three channels
    for name, position in (("rk4.csv", "0.08"), ("rk4_beam.csv", "0.12")):
        there = (line.replace(",0.1,", f",{position},") for line in lines if ",0.1,y," not in line)
        (place / name).write_text("".join(there))
    (place / "campaign.yaml").write_text(blocks(text_of(DOCS / "campaigns.md"), "yaml")[0])
    (place / "rk4").mkdir()
    shutil.copy(examples / "balancing.yaml", place / MEASURED_ELSEWHERE)
    shutil.copy(examples / "balancing.csv", place / "rk4" / "balancing.csv")
    contest, plugins = (text_of(DOCS / name) for name in ("contest.md", "plugins.md"))
    one_plus_one = next(code for code in blocks(contest, "python") if "class OnePlusOne" in code)
    uniform_search = next(code for code in blocks(plugins, "python") if "class UniformSearch" in code)
    (place / "one_plus_one.py").write_text(one_plus_one)
    for name in ("MyOptimizer", "Mine", "UniformSearch"):
        file = re.sub(r"(?<!^)([A-Z])", r"_\1", name).lower()
        (place / f"{file}.py").write_text(uniform_search.replace("UniformSearch", name))
    experiments = place / "my_conf" / "experiment"
    experiments.mkdir(parents=True)
    grid = next(code for code in blocks(text_of(DOCS / "sweeps.md"), "yaml") if "name: methods" in code)
    for name in ("methods", "mine"):
        (experiments / f"{name}.yaml").write_text(grid.replace("name: methods", f"name: {name}"))
    return place


class Planned(SystemExit):
    """The plan is made, and nothing is run."""


class LoadsOnce:
    """Hydra's loader, which composes a choice of plugins once for all commands that have it."""

    def __init__(self, loader):
        self._loader, self._loaded = loader, {}

    def load_configuration(self, config_name, overrides, run_mode):
        key = (config_name, *overrides)
        if key not in self._loaded:
            self._loaded[key] = self._loader.load_configuration(config_name, overrides, run_mode)
        return copy.deepcopy(self._loaded[key])


@pytest.fixture(scope="module")
def composed():
    """The plans of an experiment's words, by what the command line composes them with."""
    with initialize_config_dir(str(CONF), version_base="1.3"):
        loader = LoadsOnce(GlobalHydra.instance().config_loader())
        master = loader.load_configuration("config", [], RunMode.MULTIRUN)
    return lambda words: Experiment.compose_all(loader, master, for_some_plugins(words, registry.GROUPS))


@pytest.fixture
def through_main(workspace, monkeypatch, capsys):
    """Command through the whole command line, options and plain files of plugins included, up to the plan."""

    def call(words):
        experiments = []
        compose_all = Experiment.compose_all

        def stopped(*arguments):
            experiments.extend(compose_all(*arguments))
            raise Planned(0)

        monkeypatch.chdir(workspace)
        monkeypatch.setattr(sys, "argv", ["bench"])
        monkeypatch.setenv("HYDRA_FULL_ERROR", "1")
        monkeypatch.setattr(Experiment, "compose_all", stopped)
        try:
            with plain_files(workspace):
                code = main.run(words)
        finally:
            GlobalHydra.instance().clear()
        assert code == 0, capsys.readouterr().err
        return experiments

    return call


def for_this_place(words):
    """Context of a page's reader: its plugin, its experiments, and one instance of a contest's many."""
    if any(word.startswith("optimizer=uniform_search") for word in words):
        return [*words, "plugins=[uniform_search.py]"]
    if "+experiment=methods" in words:
        return [*words, "--config-dir", "my_conf"]
    if "+experiment=contest" in words and not is_a_name_alone(words):
        return [*words, "problem.instance=0", "problem.family=isotropic"]
    return words


def is_plain(words):
    """Whether settings are all that the words are."""
    return not any(word.startswith(("--", "hydra", "plugins=")) for word in words)


def is_a_name_alone(words):
    return words[0].startswith("+experiment=") and all(word.partition("=")[0] in LEAVES_CELLS for word in words[1:])


WORDS = [pytest.param(for_this_place(param.values[0][3:]), id=param.id) for param in EXPERIMENTS]


@pytest.mark.parametrize("words", [param for param in WORDS if is_plain(param.values[0])])
def test_an_experiment_is_planned(words, composed, workspace, monkeypatch):
    if is_a_name_alone(words):
        assert (CONF / "experiment" / f"{words[0].partition('=')[2]}.yaml").is_file()
        return
    monkeypatch.chdir(workspace)
    experiments = composed(words)
    assert experiments and all(experiment.plan.cells for experiment in experiments)


@pytest.mark.parametrize("words", [param for param in WORDS if not is_plain(param.values[0])])
def test_options_and_plain_files_are_taken(words, through_main):
    experiments = through_main(words)
    assert experiments and all(experiment.plan.cells for experiment in experiments)


@pytest.mark.parametrize("slip", ["problem.mehs=21", "optimizer=pos", "problem=rotor problem.file=no_rotor.yaml"])
def test_a_slip_is_noticed(slip, through_main):
    with pytest.raises(AssertionError, match="error: "):
        through_main(slip.split())


@pytest.mark.parametrize("words", HELP)
def test_help_is_printed(words, workspace, monkeypatch):
    monkeypatch.chdir(workspace)
    if "uniform_search" in words:
        words = [*words, "plugins=[uniform_search.py]"]
    words = ["runout" if word == "table3" else word for word in words[3:]]
    with plain_files(workspace):
        assert help_text(words[1:])


@pytest.mark.parametrize("words", OWN_COMMANDS)
def test_a_command_on_results_is_one(words):
    """Its help names its options; the results that it names are those of an experiment, or written by a command here."""
    name, *rest = words[3:]
    said = help_text([name])
    assert [word for word in rest if word.startswith("--") and word not in said] == []
    options = [word.partition("=")[0] for word in rest if "=" in word]
    if name == "draw":
        assert {option.partition(".")[0] for option in options} <= {PROBLEM, VALUES, OUTPUT, *OPTIONS}
    else:
        assert all(f"{option}=" in said for option in options)
    if name in ("status", "collect", "merge", "reference"):
        assert all(Path(word).name in named_results() for word in rest if not word.startswith("--"))
    elif name == "export":
        assert rest[0] in ("ioh", "coco", "csv") and rest[1] in named_results()
    elif name == "verify":
        assert (REFERENCE / f"{rest[0]}.csv").is_file()
    elif name == "new" and rest:
        assert rest[0] in (*registry.GROUPS, "effect") and len(rest) >= 2


def named_results():
    """Names of results folders: of experiments, and as `output=` and `--out` say in any command."""
    names = {path.stem for path in (CONF / "experiment").glob("*.yaml")} | {"mine", "contest_ann", "contest_bob"}
    for param in BENCH:
        words = param.values[0]
        names |= {Path(word.partition("=")[2]).name for word in words if word.startswith("output=")}
        names |= {Path(after).name for word, after in pairwise(words) if word == "--out"}
    return names


@pytest.mark.parametrize("words", OTHERS)
def test_a_script_is_there(words):
    assert words[0] in ("python", "python3"), "a command of another program: say in NOT_TRIED why it is shown"
    if words[1:2] == ["-m"]:
        assert (ROOT / f"{words[2].replace('.', '/')}.py").is_file()
    elif words[1:]:
        assert (ROOT / words[1]).is_file()


def test_reasons_are_of_commands_that_are_shown():
    lines = [" ".join(param.values[0]) for param in shown()]
    assert not [start for start in NOT_TRIED if not any(line.startswith(start) for line in lines)]


NAMED = re.compile(r"^\+?([a-z_]+)=([a-z_0-9]+)$")
OF_PLUGINS_SHOWN = ("points", "csv", "yaml", "py", "json", "png")  # of a plugin that a page makes; names of files
SET = re.compile(r"^([a-z]+)\.([a-z_]+)(?:=.*)?$")


def code_of_pages():
    for page in pages():
        for code in INLINE.findall(text_of(page)):
            for word in code.split():
                yield page.name, word


def test_experiments_and_plugins_that_text_names_exist():
    experiments = {path.stem for path in (CONF / "experiment").glob("*.yaml")} | {"methods", "mine"}
    own = {"my_optimizer", "uniform_search", "one_plus_one", "mine", "my_method"}
    for page, word in code_of_pages():
        if found := NAMED.match(word):
            group, name = found.groups()
            if group == "experiment":
                assert name in experiments, f"{page}: {word}"
            elif group in registry.GROUPS:
                assert name in {*registry.registered(group), *own}, f"{page}: {word}"


def test_settings_that_text_names_exist():
    known = {group: settings_of(group) for group in registry.GROUPS}
    for page, word in code_of_pages():
        if (found := SET.match(word)) and found[1] in known:
            assert found[2] in {*known[found[1]], *OF_PLUGINS_SHOWN}, f"{page}: {word}"


def settings_of(group):
    """All settings of a group's plugins, and the plugins' names, which may stand between."""
    names = registry.registered(group)
    return {*names, *(field.name for name in names for field in own_fields(registry.plugin_class(group, name)))}
