"""Help from what is registered: groups, plugins, their settings with defaults, units, ranges and sources."""

from __future__ import annotations

import dataclasses
import inspect
import textwrap
from collections.abc import Sequence

from bench.command_line.config_files import EXPERIMENT, folders, without_folders
from bench.command_line.offered import require_offered
from bench.command_line.plugin_words import given_files, is_of_plugins
from ksmea import registry
from ksmea.contracts import AnyEffect
from ksmea.errors import SettingError, unknown
from ksmea.parameters import Parameter
from ksmea.settings import expected_range, own_fields

EFFECT = "effect"  # chosen in settings of measurements, studies and extended problems
EXAMPLE = "three_disk"  # the problem that limits of effects are shown for

USAGE = """\
python -m bench [+experiment=NAME] [setting=value ...]      run an experiment (again: only what is missing)
python -m bench status NAME|DIR                             planned, done, failed, stale, missing runs
python -m bench explain KEY [NAME|DIR]                      why a run failed or is stale, with its traceback
python -m bench collect NAME|DIR                            tables and figures again, from plan and records alone
python -m bench merge NAME|DIR NAME|DIR ... --out DIR       parts of one experiment, done in several places, in one folder
python -m bench export ioh|coco|csv NAME|DIR [--out DIR]    the course of each run for IOHanalyzer, cocopp or a table
python -m bench import FILE --format FORMAT --out RUN.csv   a file of an instrument as the project's own: docs/own_data.md
python -m bench export measurement --out RUN.csv [X=Y ...]  a synthetic measurement as such a file
python -m bench verify TABLE [repetitions=N] [tolerance=T]  compute results/reference again and compare
python -m bench draw problem=NAME [setting=value ...]       a rotor to scale, Campbell diagram, critical speeds, mode shapes
python -m bench new KIND NAME [--file]                      an effect, method, optimizer, problem or surrogate of your own
python -m bench help [GROUP [NAME]]                         plugins, where they come from, settings, units and sources

settings of every experiment: samples repetitions seed output workers timeout memory journal share batches
  several values make a sweep:  samples=40,70  optimizer=de,pso  samples=range(40,201,40)  optimizer=glob(*)
  a plugin's own settings:      optimizer.population=50  measurement.relative=0.05
  of one plugin among several:  optimizer=de,ga optimizer.de.population=20 optimizer.ga.population=40
  lines of a grid:              label=DE,LM  "add=[{label: Mine, optimizer: mine}]"
  a plugin from a plain file:   plugins=[my_optimizer.py] optimizer=my_optimizer, named as its class (MyOptimizer)
exit code: 0 all runs have a result, 1 some failed, 2 bad input, 130 interrupted (finished runs are kept)
BENCH_TRACEBACK=1 shows the traceback of an error of input"""


def help_text(words: list[str]) -> str:
    """Help on everything, on a group, or on one plugin; with plugins=[my_optimizer.py] on those of plain files too, with
    --config-dir DIR on experiments there."""
    refused = []
    for path in given_files([word for word in words if is_of_plugins(word)]):
        try:
            registry.register_file(path)
        except SettingError as error:  # it does not take the help on the others away
            refused.append(str(error))
    asked = [word for word in without_folders(words) if not is_of_plugins(word)]
    experiments = sorted({path.stem for folder in folders(words) for path in (folder / EXPERIMENT).glob("*.yaml")})
    return "\n".join([_help_text(asked, experiments), *refused])


def _help_text(words: list[str], experiments: list[str]) -> str:
    if not words:
        groups = "\n".join(f"  {group + '=':<13}{' | '.join(registry.registered(group))}" for group in registry.GROUPS)
        effects = textwrap.fill(
            " | ".join(registry.registered(EFFECT)), 100, initial_indent="  ", subsequent_indent="  "
        )
        return f"{USAGE}\n\nexperiments: {', '.join(experiments)}\nplugins:\n{groups}\neffects (help effect NAME):\n{effects}{_from_outside()}"
    group, *names = words
    if group not in (*registry.GROUPS, EFFECT):
        raise unknown("group", group, [*registry.GROUPS, EFFECT])
    if names:
        return "\n\n".join(_plugin_text(group, name) for name in names)
    return "\n\n".join(_plugin_text_or_why_not(group, name) for name in registry.registered(group))


def _from_outside() -> str:
    """The plugins that are not this project's: where each comes from, and why it cannot be chosen where it cannot."""
    lines = []
    for group in (*registry.GROUPS, *registry.FURTHER):
        for name in registry.registered(group):
            if not (origin := registry.origin(group, name)).startswith(registry.PROJECT):
                lines.append(f"  {group}={name}: from {origin}; {_whether_it_loads(group, name)}")
        for point in registry.left_out(group):
            rename = f"left out, {registry.PROJECT} has one of this name: rename it there"
            lines.append(f"  {group}={point.name}: from {registry.origin_of(point)}; {rename}")
    return "\n".join(["\nplugins from outside:", *lines]) if lines else ""


def _whether_it_loads(group: str, name: str) -> str:
    try:
        require_offered(group, name)
    except SettingError as error:
        return f"cannot be chosen: {str(error).removeprefix(f'{group}={name}: ')}"
    return "loads"


def _plugin_text_or_why_not(group: str, name: str) -> str:
    try:
        return _plugin_text(group, name)
    except SettingError as error:  # a broken plugin does not take the help on the others away
        return f"{error} [{registry.origin(group, name)}]"


def _plugin_text(group: str, name: str) -> str:
    settings = registry.plugin_class(group, name)
    summary = (settings.__doc__ or "").strip().split("\n\n")[0]
    lines = [f"{group}={name}: {' '.join(summary.split())} [{registry.origin(group, name)}]"]
    for field in own_fields(settings):
        lines.append(f"  {group}.{field.name}={_default(field)}  {_remarks(field)}")
    return "\n".join([*lines, *(_effect_lines(name) if group == EFFECT else _why_not_offered(group, name))])


def _why_not_offered(group: str, name: str) -> list[str]:
    """Why a plugin cannot be chosen on the command line; nothing where it can."""
    try:
        require_offered(group, name)
    except SettingError as error:
        return [f"  cannot be chosen: {error}"]
    return []


def _effect_lines(name: str) -> list[str]:
    """What an effect has besides its settings: its unknowns, what can look alike, and its physics with its source."""
    effect = registry.create(EFFECT, name, {})
    lines = []
    for parameter in _parameters_of_example(effect):
        lower, upper = parameter.lower / parameter.si_per_unit, parameter.upper / parameter.si_per_unit
        lines.append(f"  unknown {parameter.name}: {lower:g} to {upper:g} {parameter.unit} (problem={EXAMPLE})")
    lines += [f"  can look like {alias}: {what}" for alias, what in effect.aliases.items()]
    physics = inspect.getdoc(inspect.getmodule(type(effect))) or ""
    return lines + [f"  | {line}".rstrip() for line in physics.splitlines()]


def _parameters_of_example(effect: AnyEffect) -> Sequence[Parameter]:
    """Its unknowns on a problem that everyone has; none where it does not fit that."""
    try:
        return effect.parameters(registry.create("problem", EXAMPLE, {}).build())
    except Exception:  # whatever an effect for other problems does with it
        return ()


def _default(field: dataclasses.Field) -> str:
    if field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
        return "?"
    default = field.default_factory() if field.default_factory is not dataclasses.MISSING else field.default
    if default is None:
        return "null"
    return str(default).lower() if isinstance(default, bool) else str(default)


def _remarks(field: dataclasses.Field) -> str:
    metadata = field.metadata
    remarks = [metadata.get("help", "")]
    if metadata.get("unit"):
        remarks.append(f"[{metadata['unit']}]")
    if metadata.get("choices"):
        remarks.append(f"one of {', '.join(metadata['choices'])}")
    elif expected_range(metadata):
        remarks.append(f"({expected_range(metadata)})")
    if metadata.get("source"):
        remarks.append(f"– {metadata['source']}")
    return " ".join(remark for remark in remarks if remark)
