"""Next steps after a study, as commands with the arguments of its rotor and measurement."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from bench.command_line.overrides import path_word
from bench.plan.page import Block, Command
from bench.plan.plan import Cell, Plan
from bench.reports.design.next_measurement import Next, from_here
from bench.reports.pages.made_by import command_line
from ksmea.errors import visible
from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.records.identification import IdentificationRecord, LackOfFit

KEPT = ("problem", "measurement", "plugins", "seed", "units")  # groups of settings that say which rotor and data
MEASURED = ("file", "campaign")


def after_identification(plan: Plan, cell: Cell, record: IdentificationRecord) -> Iterator[Block]:
    """The diagnosis of a fit that is rejected; of another one, what to measure in addition."""
    if record.lack_of_fit is not None and record.lack_of_fit.rejected:
        yield _diagnosis(plan, cell, "Look for what the model lacks:")
    else:
        words = ["+experiment=plan", *_same_data(plan, cell)]
        yield Command(command_line(words), "What to measure in addition, to know the unknowns better:")


def after_diagnosis(
    plan: Plan, cell: Cell, record: DiagnosisRecord, following: Next | None, extended: str | None
) -> Iterator[Block]:
    """The further measurement that is recommended, and the extended model taken on."""
    yield from after_plan(following)
    if extended is not None:
        words = [word for word in _same_data(plan, cell) if not word.startswith("problem")]
        words = ["+experiment=identify", "problem=extended", path_word("problem.file", extended), *words]
        words += [path_word("output", _beside(plan, extended))]  # that of the model as given stays what it is
        yield Command(command_line(words), "Identify with the extended model:")
    if record.verdict in ("adequate", "not observable"):
        words = ["+experiment=plan", *_same_data(plan, cell)]
        yield Command(command_line(words), "What to measure in addition, to know the unknowns better:")


def before_looking_ahead(plan: Plan, cell: Cell, test: LackOfFit | None) -> Iterator[Command]:
    """The diagnosis of a fit that is rejected: what looks ahead from there holds for a wrong model."""
    if test is not None and test.rejected:
        yield _diagnosis(plan, cell, "Before anything is made of this, look for what the model lacks:")


def as_text(commands: Iterable[Command]) -> Iterator[str]:
    """Commands as a terminal has them."""
    yield from (f"{each.about}\n  {each.words}" for each in commands)


def _diagnosis(plan: Plan, cell: Cell, about: str) -> Command:
    return Command(command_line(["+experiment=diagnose", *_same_data(plan, cell)]), about)


def after_plan(following: Next | None) -> Iterator[Block]:
    """The steps to a recommended measurement, and its command."""
    if following is not None:
        yield Command(
            following.command, " ".join(visible(step) for step in following.steps) or "Take the recommended run along:"
        )


def _beside(plan: Plan, extended: str) -> str:
    """Folder of an extended model's identification, next to its diagnosis, as identify_run_up_extended."""
    folder = Path(extended).parent.absolute()  # '.' has no name
    own = f"{folder.name}_".removeprefix(f"{plan.name}_").removesuffix(
        "_"
    )  # what the folder's name says besides the plan's
    return from_here(folder.parent / "_".join(filter(None, ["identify", own, "extended"])))


def _same_data(plan: Plan, cell: Cell) -> list[str]:
    """Words of a plan that choose its rotor and measurement, and the source of an experiment's data."""
    kept = [word for word in plan.command if word.partition("=")[0].lstrip("+").partition(".")[0] in KEPT]
    source = cell.chosen("measurement")
    is_said = any(word.startswith("measurement=") for word in kept)
    return kept if is_said or source not in MEASURED else [*kept, f"measurement={source}"]
