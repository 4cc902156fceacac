"""Plan of an experiment from its configurations.

Cells have checked settings, runs have keys and seeds.
"""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hydra.core.config_loader import ConfigLoader
from omegaconf import DictConfig, OmegaConf

from bench.command_line.bench_settings import BenchConfig, bench_fields
from bench.command_line.corrected_command import quoted
from bench.command_line.grid import LABEL, grid_points
from bench.command_line.overrides import Choice, as_given, override, parse
from bench.command_line.plugin_settings import short
from bench.command_line.plugin_words import require_registered
from bench.command_line.word_shapes import NAMED
from bench.plan.assumed_values import assumed_values_in_errors, with_assumed_values
from bench.plan.composer import Composer, Compositions
from bench.plan.fleet import MEASURED, ROTOR, fleet_axes, with_rotors
from bench.plan.folder import own_folder, require_own_folder
from bench.plan.left_out import left_out_lines, outside_in, planning, with_usable
from bench.plan.parameter_facts import FactsOfCells
from bench.plan.plan import Cell, Plan, ReportSettings, all_runs, is_file_name, own_seed
from bench.plan.provenance import (
    PARTS,
    code_digest,
    commit,
    library_versions,
    names_of_parts,
    platform_name,
    plugin_files,
    used_modules,
)
from bench.plan.report import report_named
from bench.plan.setup import FINGERPRINTS, Setup, fingerprints
from bench.plan.size import require_size
from bench.plan.study import Study
from bench.storage.own_files import PAPER
from ksmea.errors import PluginFailure, SettingError, shortened, unknown
from ksmea.measurement.notation import Notation
from ksmea.plugins import registry
from ksmea.plugins.first_import import require_survived
from ksmea.records.record import Record
from ksmea.settings.settings import check_values

# Settings of the whole experiment, which cannot be an axis of it.
WHOLE = (
    "name",
    "plugins",
    "repetitions",
    "output",
    "units",
    "table",
    "paper",
    "figures",
    "exact",
    "includes",
    "own_seeds",
    "standard",
    "grid",
    "add",
    "cross",
    "force",
)
REFERENCED = re.compile(r"\$\{([\w.]+)\}")  # settings that a text is made of
OF_FILE = re.compile(r"\$\{of_file:\$\{\w+\}\}")  # of the file that all runs have, or of all files of a fleet
# Settings of how it is dealt out to jobs.
DEALING = ("batches", "share", "wait")
# Settings of how its jobs work, passed on to them; none of them changes a result.
WORKING = ("workers", "timeout", "memory", "journal")


@dataclass(frozen=True)
class Experiment:
    """A plan and how its runs are dealt out."""

    plan: Plan
    output: Path
    batches: int
    share: tuple[Path, ...]  # folders whose finished runs of the same key are taken over
    working: tuple[str, ...]  # overrides for the jobs
    has_left_out: bool = False  # plugins that cannot be used, which the plan's notes name

    @classmethod
    def compose_all(cls, loader: ConfigLoader, master: DictConfig, arguments: list[str]) -> list[Experiment]:
        """The experiment of a command line, or all that it includes, each in a folder below its own."""
        compositions = Compositions(loader, master)
        config = Composer(compositions, _fixed(parse(arguments)), {}).outline
        if not config.includes:
            return [cls.compose(compositions, arguments)]
        output = Path(config.output).absolute()
        own = [
            word for word in arguments if word.partition("=")[0].lstrip("+") not in ("experiment", "output", "share")
        ]
        included: list[Experiment] = []
        for name in config.includes:
            words = [f"+experiment={name}", *own, override("output", str(output / name))]
            share = [*config.share, *(str(experiment.output) for experiment in included), str(output.parent / name)]
            included.append(cls.compose(compositions, words, share))
        return included

    @classmethod
    def compose(cls, compositions: Compositions, arguments: list[str], share: Sequence[str] = ()) -> Experiment:
        """One experiment; finished runs of the same key are also taken over from the folders in `share`."""
        words = parse(arguments)
        fleet = fleet_axes(words)
        chosen = [label for choice in words if choice.key == LABEL for label in choice.values]
        choices = [choice for choice in words if choice.key != LABEL]
        fixed = _fixed(choices)
        swept = {choice.key: choice.values for choice in choices if len(choice.values) > 1}
        swept |= {MEASURED: fleet[MEASURED]} if fleet else {}
        _check_axes(swept)
        composer = Composer(compositions, fixed, swept, chosen)
        config = composer.whole
        _check_whole(config)
        for block in composer.blocks:
            _check_axes(block)
        _require_one_folder(config, {*swept, *(key for block in composer.blocks for key in block)})
        fixed_keys = {choice.key for choice in fixed}
        require_size(composer.blocks, swept, fixed_keys, config.repetitions, config.force)
        usable, left_out = with_usable(grid_points(composer.blocks, swept, fixed_keys))
        points = with_rotors(composer.own(usable), fleet)
        modules: dict[str, str] = {}
        cells, failures = _cells(composer, points, modules)
        left_out += left_out_lines(failures)
        versions = library_versions()
        plan = Plan(
            name=config.name,
            report=ReportSettings(_table(config.table, cells), config.paper, tuple(config.figures), config.exact),
            axes=_axes(points),
            command=tuple(map(as_given, arguments)),
            commit=commit(),
            versions=versions,
            platform=platform_name(),
            modules=modules,
            cells=cells,
            runs=all_runs(cells, config.repetitions, versions),
            plugins={word: path for cell in cells for word, path in plugin_files(cell.settings).items()},
            notes=(*left_out, *_compared(composer, cells)),
        )
        working = tuple(override(key, config[key]) for key in WORKING)
        output = Path(config.output).absolute()
        if any(choice.key == "output" for choice in words):
            require_own_folder(plan, output)
        else:
            output = own_folder(plan, output)
        if config.table is not None:
            report_named(config.table).check_plan(plan)
        shared = tuple(map(Path, [*config.share, *share]))
        return cls(plan, output, config.batches, shared, working, has_left_out=bool(left_out))


def _compared(composer: Composer, cells: Sequence[Cell]) -> list[str]:
    """A note on local searches that are off because optimisers are compared."""
    off = [
        key
        for key in composer.compared
        if any((cell.settings.get("method") or {}).get(key.partition(".")[2]) is False for cell in cells)
    ]
    if not off:
        return []
    said = " and ".join(f"{key}=false" for key in off)
    return [f"optimisers are compared as they stop, with {said}: after a local search all would end at one optimum"]


def _fixed(choices: Iterable[Choice]) -> list[Choice]:
    """Settings with one value on the command line; the others are swept."""
    return [choice for choice in choices if len(choice.values) <= 1]


def _check_axes(keys: Iterable[str]) -> None:
    for key in keys:
        if key in (*WHOLE, *DEALING, *WORKING, "batch", "experiment"):
            raise SettingError(
                "expected one value for the whole experiment, got several; give one",
                setting=key,
                meant=quoted if key in NAMED else None,
            )


def _check_whole(config: DictConfig) -> None:
    known = bench_fields()
    for key in config:
        if key not in (*known, "hydra"):
            raise unknown("setting", str(key), [*known, "experiment"])
    require_registered(config.plugins)
    check_values(BenchConfig, _own(config, set(known) - {*registry.GROUPS}))
    Notation().with_words(config.units)
    if config.repetitions < 1 and config.table != "settings":
        raise SettingError(f"expected a number at least 1, got {config.repetitions}", setting="repetitions")
    if not is_file_name(config.name):
        raise SettingError(
            f"expected the name of a file, got '{shortened(config.name)}'; choose another", setting="name"
        )
    if not config.output:
        raise SettingError("expected a folder, output=. for the working directory, got nothing", setting="output")
    if config.paper is not None and not (PAPER / f"{config.paper}.csv").is_file():
        raise unknown("table of the paper", config.paper, [path.stem for path in PAPER.glob("*.csv")])
    if config.table is not None and config.table not in registry.registered("report"):
        raise unknown("table", config.table, registry.registered("report"))
    for folder in config.share:
        if not Path(folder).is_dir():
            raise SettingError(f"expected folders of results, found none at {folder}", setting="share")


def _require_one_folder(config: DictConfig, axes: Collection[str]) -> None:
    """Raise `SettingError` if name or folder of the results contain a setting with several values.

    One of the values would name the folder of all.
    """
    for key in ("name", "output"):
        masked: Any = OmegaConf.to_container(OmegaConf.masked_copy(config, [key]), resolve=False)
        text = str(masked[key])
        for named in REFERENCED.findall(OF_FILE.sub("", text)):
            if any(short(axis) == named or named.startswith(f"{short(axis)}.") for axis in axes):
                raise SettingError(
                    f"expected one {key} for the whole experiment, got ${{{named}}}, which has several values; leave it out",
                    setting=key,
                )


def _own(config: DictConfig, names: Iterable[str]) -> dict[str, Any]:
    """Values of settings by name."""
    values: Any = OmegaConf.to_container(OmegaConf.masked_copy(config, list(names)))
    return dict(values)


def _cells(
    composer: Composer, points: Sequence[dict[str, Any]], modules: dict[str, str]
) -> tuple[tuple[Cell, ...], list[PluginFailure]]:
    """The cell of each point, and why plugins from outside have none.

    A file of a fleet that cannot be used costs its own run alone, which fails with the reason; `SettingError` if no
    file can be used with the same settings, so that it is not the file.
    """
    made: dict[int, Cell] = {}
    failures: list[PluginFailure] = []
    refused: dict[int, SettingError] = {}
    facts, tried = FactsOfCells(), dict[str, PluginFailure | None]()
    for index, point in enumerate(points):
        try:
            config = composer.at(point)
            chosen = {group: OmegaConf.to_container(config[group], resolve=True) for group in registry.GROUPS}
            _require_survived(config, point, chosen, tried)
            made[index] = _cell(config, point, chosen, modules, facts)
        except PluginFailure as failure:
            failures.append(failure)
        except SettingError as error:
            if MEASURED not in point:
                raise
            refused[index] = error
    for index, reason in refused.items():
        alike = (cell for cell in made.values() if _differ_by_file(cell.place, points[index]))
        if (other := next(alike, None)) is None:
            raise reason
        made[index] = _with_file(other, composer.at(points[index]), points[index])
    if failures and not made:
        raise failures[0]
    return _each_once(made[index] for index in sorted(made)), failures


def _each_once(cells: Iterable[Cell]) -> tuple[Cell, ...]:
    """The cells, each once that does the same runs at the same place.

    A method without an optimiser is one cell, however many optimisers it is crossed with.
    """
    known: dict[str, Cell] = {}
    for cell in cells:
        same = json.dumps([cell.settings, cell.seed, cell.place], sort_keys=True, default=str)
        known.setdefault(same, cell)
    return tuple(known.values())


def _require_survived(
    config: DictConfig, point: dict[str, Any], chosen: dict[str, Any], tried: dict[str, PluginFailure | None]
) -> None:
    """Raise `PluginFailure` if planning with these plugins from outside ends the process.

    The first cell of each is tried in a fork.
    """
    theirs = " ".join(outside_in(chosen))
    if theirs and theirs not in tried:
        tried[theirs] = None
        try:
            require_survived(theirs, lambda: _cell(config, point, chosen, {}, FactsOfCells()))
        except PluginFailure as failure:
            tried[theirs] = failure
    if (failed := tried.get(theirs)) is not None:
        raise failed


def _differ_by_file(place: Mapping[str, Any], point: Mapping[str, Any]) -> bool:
    return all(place.get(key) == value for key, value in point.items() if key not in (MEASURED, ROTOR))


def _with_file(cell: Cell, config: DictConfig, point: Mapping[str, Any]) -> Cell:
    """Cell with the files of another point in place of its own, as far as known without reading them."""
    settings = {key: value for key, value in cell.settings.items() if key not in FINGERPRINTS.values()}
    files = {group: OmegaConf.to_container(config[group], resolve=True) for group in FINGERPRINTS if settings[group]}
    settings = {**settings, **files}
    return dataclasses.replace(
        cell, place={**cell.place, **point}, settings=settings, seed=_seed(config, point, settings)
    )


def _cell(
    config: DictConfig, point: dict[str, Any], chosen: dict[str, Any], modules: dict[str, str], facts: FactsOfCells
) -> Cell:
    """The settings of one point, checked by making its plugins; what the method ignores is left out.

    `chosen` are the settings of its plugins by group. The modules that it uses are added to `modules`.
    """
    check_values(BenchConfig, _own(config, ("samples", "seed")))
    with planning(chosen):
        return _planned(config, point, chosen, modules, facts)


def _planned(
    config: DictConfig, point: dict[str, Any], settings: dict[str, Any], modules: dict[str, str], facts: FactsOfCells
) -> Cell:
    settings = with_assumed_values(settings | {"samples": config.samples})
    with assumed_values_in_errors(settings):
        setup = Setup.of(settings)
    plugins = setup.plugins
    study = plugins["study"]
    if not isinstance(study, Study):
        raise SettingError(
            f"study={settings['study']['name']}: expected a subclass of bench.plan.study.Study, got {type(study).__name__};"
            " make it one"
        )
    study.validate(setup)
    settings |= {FINGERPRINTS[group]: fingerprint for group, fingerprint in fingerprints(plugins).items()}
    if parts := names_of_parts(filter(None, plugins.values())):
        settings[PARTS] = parts
    ignored = {*study.ignores, *plugins["method"].ignores}
    for part in ignored:
        settings[part] = None
    # A model that is worth a journal is too expensive to be evaluated where nothing keeps the answer.
    parameters = facts.of(setup, with_crlb=not config.journal)
    used = used_modules(settings, plugin_files(settings))
    modules |= used
    samples = None if "samples" in ignored and "samples" not in point else config.samples
    without = ignored & {*registry.GROUPS}
    place = {"samples": samples} | {
        key: None if key.partition(".")[0] in without else value for key, value in point.items()
    }
    return Cell(place, settings, _seed(config, point, settings), parameters, code_digest(used))


def _seed(config: DictConfig, point: Mapping[str, Any], settings: Mapping[str, Any]) -> int:
    """Seed of a cell: the experiment's seed, or one of the cell's own (`own_seeds`)."""
    if config.own_seeds == "instance":
        return own_seed(config.seed, {group: settings[group] for group in ("problem", "measurement")})
    if config.own_seeds == "label":
        return own_seed(
            config.seed, {key: value for key, value in point.items() if key.startswith(("label", "measurement"))}
        )
    return int(config.seed)


def _table(asked: str | None, cells: Sequence[Cell]) -> str:
    """The kind of table: as asked, or the one that the cells' study has.

    It is made of the records of one study.
    """
    studies = sorted({cell.settings["study"]["name"] for cell in cells})
    if len(studies) > 1:
        raise SettingError(
            f"expected one for the whole experiment, got {', '.join(studies)}; give one", setting="study"
        )
    study: Any = registry.plugin_class("study", studies[0])
    table: str = asked or study.report
    if not _is_made_of(table, study):
        fitting = []
        for name in registry.registered("report"):
            with suppress(SettingError):  # of a report from outside, whose study is missing or broken
                fitting += [name] if _is_made_of(name, study) else []
        raise SettingError(f"expected one of {', '.join(fitting)} for study={studies[0]}, got {table}", setting="table")
    return table


def _is_made_of(table: str, study: type[Study]) -> bool:
    """Whether a report can use a study's records: its own study, or one with an equal record type."""
    own: Any = registry.plugin_class("study", report_named(table).study)
    return own is study or (own.record is study.record and own.record is not Record)


def _axes(points: list[dict[str, Any]]) -> tuple[str, ...]:
    """The keys of the grid, samples always first: the columns that tell a table's fields apart."""
    return tuple(dict.fromkeys(["samples", *(key for point in points for key in point)]))
