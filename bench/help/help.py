"""Help: the first page, the choice of the page that answers the arguments, and the version."""

from __future__ import annotations

import platform
import textwrap
from importlib.metadata import version

from bench.command_line.config_dirs import experiment_files, folders, without_folders
from bench.storage.own_files import checkout_commit
from ksmea.errors import SettingError
from ksmea.plugins.names import FURTHER, GROUPS, PROJECT, left_out, origin, origin_of, registered

EFFECT = "effect"  # chosen in settings of measurements, studies and extended problems

START = """\
Finds bearing coefficients and unbalance of a rotor from its measured unbalance response, and compares ways of doing that.

try it, a minute:           python -m bench +experiment=table3
a machine of your own:      python -m bench +experiment=diagnose problem=rotor problem.file=my_rotor.yaml \\
                                measurement=file measurement.path=run_up.csv
a method of your own:       python -m bench new optimizer my_search

python -m bench help                 all commands, experiments and plugins
python -m bench help table3          one of them, or a setting: help samples
python -m bench --version            what is installed
Nothing is run until one of these is given. Results go to results/ below the working directory."""

USAGE = """\
python -m bench [+experiment=NAME] [setting=value ...]      run an experiment (again: only what is missing)
python -m bench status NAME|DIR                             runs done, running, interrupted, failed, stale, missing
python -m bench explain KEY [NAME|DIR]                      why a run failed or is stale, with its traceback
python -m bench collect NAME|DIR                            tables and figures again, from plan and records alone
python -m bench open [NAME|DIR]                             the page of results in the browser; without a name, that over all
python -m bench compare NAME|DIR NAME|DIR [--out DIR]       two identifications or diagnoses side by side, as text, table and page
python -m bench merge NAME|DIR NAME|DIR ... --out DIR       parts of one experiment, done in several places, in one folder
python -m bench export ioh|coco|csv NAME|DIR [--out DIR]    the course of each run for IOHanalyzer, cocopp or a table
python -m bench import FILE --format FORMAT --out RUN.csv   a file of an instrument as the project's own: docs/own_data.md
python -m bench import rotor MODEL [--out ROTOR.yaml]       a rotor model of ROSS, XLTRC2 or tables: docs/import_rotor.md
python -m bench export measurement --out RUN.csv [X=Y ...]  a synthetic measurement as such a file
python -m bench verify TABLE [repetitions=N] [tolerance=T]  compute results/reference again and compare
python -m bench draw problem=NAME [setting=value ...]       a rotor to scale, Campbell diagram, critical speeds, mode shapes
python -m bench new KIND NAME [--file]                      an effect, method, optimizer, problem or surrogate of your own
python -m bench reference NAME|DIR                          make results/reference of an experiment, by committed code
python -m bench completion bash|zsh                         completion by the Tab key: eval "$(python -m bench completion bash)"
python -m bench help [NAME ...]                             a command, experiment, plugin, group, effect, setting or term

settings of every experiment: samples repetitions seed output workers timeout memory journal share batches
  several values make a sweep:  samples=40,70  optimizer=de,pso  samples=range(40,201,40)  optimizer=glob(*)
  a plugin's own settings:      optimizer.population=50  measurement.relative=0.05
  of one plugin among several:  optimizer=de,ga optimizer.de.population=20 optimizer.ga.population=40
  lines of a grid:              label=DE,LM  "add=[{label: Mine, optimizer: mine}]"
  a plugin from a plain file:   plugins=[my_optimizer.py] optimizer=my_optimizer, named as its class (MyOptimizer)
options of every command: -q only errors; -v each run as it ends, tracebacks; -h, --help; --version
exit code: 0 all runs have a result, 1 some failed, were interrupted or are missing, 2 bad input, 130 interrupted (finished runs are kept)
BENCH_TRACEBACK=1 shows the traceback of an error of input"""


def start_text() -> str:
    """First steps."""
    return START


def help_text(words: list[str]) -> str:
    """Help on everything, or on whatever has one of the names.

    plugins=[my_optimizer.py] adds plugins of plain files, --config-dir DIR experiments there, and problem=NAME limits
    of effects on that problem.
    """
    refused: list[str] = []
    if any(_is_of_plugins(word) for word in words):
        from bench.command_line.plugin_words import registered_or_why_not  # loads contracts and numpy

        refused = registered_or_why_not(words)
    asked = [word for word in without_folders(words) if not _is_of_plugins(word)]
    experiments = experiment_files(folders(words))
    if not asked:
        return "\n".join([_first_page(list(experiments)), *refused])
    from bench.help.topics import topic_text  # loads contracts and numpy

    return "\n".join([topic_text(asked, experiments, USAGE), *refused])


def _is_of_plugins(word: str) -> bool:
    return word.lstrip("+").startswith("plugins=")


def _first_page(experiments: list[str]) -> str:
    groups = "\n".join(f"  {group + '=':<13}{' | '.join(registered(group))}" for group in GROUPS)
    effects = textwrap.fill(" | ".join(registered(EFFECT)), 100, initial_indent="  ", subsequent_indent="  ")
    listed = ", ".join(sorted(experiments))
    return (
        f"{USAGE}\n\nexperiments (help NAME): {listed}\nplugins (help NAME):\n{groups}\n"
        f"effects (help effect NAME):\n{effects}{_from_outside()}"
    )


def _from_outside() -> str:
    """The plugins that are not this project's.

    The help states where each comes from, or why it cannot be chosen.
    """
    lines = []
    for group in (*GROUPS, *FURTHER):
        for name in registered(group):
            if not (place := origin(group, name)).startswith(PROJECT):
                lines.append(f"  {group}={name}: from {place}; {_whether_it_loads(group, name)}")
        for point in left_out(group):
            rename = f"left out, {PROJECT} has one of this name: rename it there"
            lines.append(f"  {group}={point.name}: from {origin_of(point)}; {rename}")
    return "\n".join(["\nplugins from outside:", *lines]) if lines else ""


def _whether_it_loads(group: str, name: str) -> str:
    from bench.command_line.schema import plugin_schema  # loads contracts and numpy

    try:
        plugin_schema(group, name)
    except SettingError as error:
        return f"cannot be chosen: {error.reason}"
    return "loads"


def version_text() -> str:
    """Version, commit and Python: 'ksmea-bench 0.1.0 (commit 1a2b3c4d5e6f, Python 3.11.2)'.

    A '+' behind a commit: files differ from it.
    """
    commit = checkout_commit()
    return f"{PROJECT} {version(PROJECT)} ({f'commit {commit}, ' if commit else ''}Python {platform.python_version()})"
