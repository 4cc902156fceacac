"""Planning of measurements: speeds, probes, trial unbalance or numbers to add.

With them the unknowns become known best. Numbers of the drawing are measured.

The plan holds near the values that it is made for. Next to each choice stands what as many data give without a plan.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError, unknown
from ksmea.inference.known_numbers import Numbers, own_numbers_as_noise, prior_data
from ksmea.inference.optimal_design import (
    Criterion,
    choose,
    crlb,
    data_rows,
    information,
    mean_axis_reduction_pct,
)
from ksmea.measurement.channel import Channel, further_directions
from ksmea.problem.parameters import Parameters
from ksmea.problem.problem import Problem
from ksmea.problem.trial_weights import equal_unbalance, weight_positions
from ksmea.records.planning import Addition, Candidates, Family, PlanningRecord, Step, Unknown
from ksmea.records.record import finite
from ksmea.settings.settings import Settings, setting
from ksmea.studies.design_point import DesignPoint
from ksmea.studies.identifiability import identifiability_of
from ksmea.studies.stability import stability_of
from ksmea.units import DEGREE, GRAM_MILLIMETRE

# Of the largest present motion: a trial weight that leaves no more cancels the unbalance, and what is left is rounding.
STILL = 1e-9
EXACT = 1e4  # times as well known as stated: of what a number adds to a variance that leaves 1e-8


@dataclass(frozen=True)
class PlanningOptions(Settings):
    """Candidates to add, and the unknowns to determine with them."""

    target: str | None = setting(
        None,
        "unknown that is to become known best; null: all of them together, by the volume of their confidence ellipsoid",
        source="Atkinson, Donev & Tobias 2007",
    )
    add: int = setting(10, "number of speeds to add, 0: none are considered", at_least=0)
    sensors: int = setting(
        2, "number of probes to add, each in one direction, where none is yet; 0: none are considered", at_least=0
    )
    band: list[float] = setting(
        [0.5, 1.5],
        "where speeds may be added: from the first number times the lowest present speed to the second times the highest;"
        " [1, 1] stays within the present band",
        above=0,
    )
    n_candidate: int = setting(
        200, "number of equally spaced speeds to choose from; sharp resonances may lie between them", at_least=2
    )
    repeats: int = setting(1, "how often one and the same speed may be added", at_least=1)
    trial_unbalance: float | None = setting(
        None,
        "trial unbalance of a second run; null: such that where it acts most it makes as much vibration (rms over all data)"
        " as there is now, to two digits",
        unit="g mm",
        above=0,
    )
    trial_sites: list[float] | None = setting(
        None,
        "positions of a trial unbalance; null: the disks, or any site if there are no disks",
        unit="m",
        at_least=0,
    )
    trial_phases: list[float] = setting(
        [0.0, 90.0, 180.0, 270.0], "phases that it may have; an empty list: no trial run is considered", unit="deg"
    )

    numbers: int = setting(
        3,
        "number of numbers known to a tolerance to measure better, as if they were exact; 0: none are considered",
        at_least=0,
    )

    def check(self) -> None:
        if len(self.band) != 2:
            raise SettingError(f"band: expected two numbers, got {list(self.band)}")
        if self.add > self.n_candidate * self.repeats:
            raise SettingError(
                f"add: expected at most n_candidate × repeats = {self.n_candidate * self.repeats} speeds, got {self.add}"
            )

    def check_problem(self, problem: Problem) -> None:
        """Raise `SettingError` where the options do not fit a problem."""
        names = problem.parameters.names
        has_numbers = self.numbers and len(Numbers.of(problem))
        if not (self.add or self.sensors or self.trial_phases or has_numbers):
            raise SettingError("add, sensors, trial_phases: expected something to add, got 0, 0 and no phase")
        if self.target is not None and self.target not in names:
            raise unknown("parameter in study.target:", self.target, names)
        lowest, highest = self.speed_limits(problem)
        if lowest >= highest and self.add:
            raise SettingError(
                f"band: expected room for speeds, got {lowest:g} to {highest:g} rad/s; give [lower, upper] factors"
            )
        if problem.takes_unbalance:
            for position in self.trial_sites or []:
                try:
                    problem.with_unbalance(position, GRAM_MILLIMETRE, 0.0)
                except SettingError as error:
                    raise SettingError(f"study.trial_sites: {error}") from error

    def speed_limits(self, problem: Problem) -> tuple[float, float]:
        """Lowest and highest candidate speed, rad/s."""
        return float(self.band[0] * np.min(problem.speed)), float(self.band[1] * np.max(problem.speed))


def planning_study(point: DesignPoint, options: PlanningOptions | None = None) -> PlanningRecord:
    """Additions to data with which one unknown (c-optimal) or all (D-optimal) become known best.

    The data are on the problem's speeds and channels, near a point.
    """
    options = options or PlanningOptions()
    problem, x, noise = point.problem, point.x, point.noise
    options.check_problem(problem)
    parameters = problem.parameters

    def rows_of(problem: Problem, numbers: Numbers) -> Array:
        return data_rows(problem, x, noise, point.kind, noise_known=point.noise_known, numbers=numbers)

    target = range(len(parameters)) if options.target is None else [parameters.names.index(options.target)]
    numbers = Numbers.of(problem, point.numbers)
    present = _Present(problem, x, Criterion(tuple(target)), rows_of, numbers)
    found = [
        family(present, options) for family in (_speeds, _probes, _trial_run, *([_numbers] if len(numbers) else []))
    ]
    considered = np.array([*problem.speed, *options.speed_limits(problem)])
    remarks = [*problem.remarks_at(considered), *point.remarks, *(entry for entry in found if isinstance(entry, str))]
    if np.all(np.equal(noise.floor, 0)):
        remarks.append(
            "the noise is proportional to each value: positions and speeds of hardly any motion count like all others;"
            " measurement.floor says what the probes resolve"
        )
    return PlanningRecord(
        target=options.target,
        parameters=tuple(
            Unknown(
                name=item.name,
                unit=item.unit,
                si_per_unit=item.si_per_unit,
                true=float(value),
                range_sd=(item.upper - item.lower) / math.sqrt(12),  # of a value drawn evenly between the limits
            )
            for item, value in zip(parameters, x)
        ),
        speed_from=float(np.min(problem.speed)),
        speed_to=float(np.max(problem.speed)),
        n_speed=len(problem.speed),
        crlb=_listed(present.crlb),
        families=tuple(entry for entry in found if isinstance(entry, Family)),
        remarks=tuple(remarks),
        stability=stability_of(
            *(problem, x, noise, point.kind),
            noise_known=point.noise_known,
            information=identifiability_of(point) if point.numbers else None,
        ),
        lack_of_fit=point.lack_of_fit,
    )


@dataclass(frozen=True)
class _Present:
    """The present data and their information.

    `rows_of` gives the data rows of any problem, with the columns of `numbers`. Their priors are present data in
    addition to the data of a run.
    """

    problem: Problem
    x: Array  # (d,) SI
    criterion: Criterion
    rows_of: Callable[[Problem, Numbers], Array]
    numbers: Numbers
    data: Array = field(init=False)  # (m, k), of the run
    rows: Array = field(init=False)  # (m + n_prior, k)
    crlb: Array = field(init=False)  # (d,) SI

    def __post_init__(self) -> None:
        data = self.of(self.problem)
        priors = prior_data(self.problem.parameters, self.numbers, data.shape[-1])
        object.__setattr__(self, "data", _flat(data))
        object.__setattr__(self, "rows", np.concatenate([self.data, priors]))
        object.__setattr__(self, "crlb", self.crlb_of(self.rows))

    def of(self, problem: Problem) -> Array:
        """Data rows (n_part, n_speed, n_channel, k) that a problem gives."""
        return self.rows_of(problem, self.numbers)

    @property
    def parameters(self) -> Parameters:
        return self.problem.parameters

    @property
    def target(self) -> list[int]:
        """Indices of the unknowns that are to become known."""
        return list(self.criterion.targets)

    def crlb_of(self, rows: Array) -> Array:
        """CRLBs (d,), SI, of data rows (m, k)."""
        return crlb(rows, len(self.parameters)) * self.parameters.width

    def reduction_pct(self, rows: Array) -> float | None:
        """Decrease of the CRLB in per cent, without any prior.

        None if something becomes known that was not known at all.
        """
        crlb = self.crlb_of(rows)
        if np.any(np.isinf(self.crlb[self.target]) != np.isinf(crlb[self.target])):
            return None
        if len(self.target) > 1:
            return mean_axis_reduction_pct(self.rows, rows, len(self.parameters))
        before, after = self.crlb[self.target[0]], crlb[self.target[0]]
        return 0.0 if np.isinf(before) else float(100 * (1 - after / before))


def _speeds(present: _Present, options: PlanningOptions) -> Family | str:
    """Speeds to add for all present channels.

    Unplanned speeds are as many in the middle of equal parts of the band.
    """
    if not options.add:
        return "no speeds are considered: study.add is 0"
    problem = present.problem
    lowest, highest = np.min(problem.speed), np.max(problem.speed)
    speed = np.linspace(*options.speed_limits(problem), options.n_candidate)
    rows = present.of(problem.at(speed, problem.channels))

    def spread(count: int) -> Array:
        evenly = lowest + (highest - lowest) * (np.arange(count) + 0.5) / count
        return present.of(problem.at(evenly, problem.channels))

    additions = [Addition(speed=float(value)) for value in speed]
    blocks = [_flat(rows[:, index]) for index in range(len(speed))]
    return _family(present, "speeds", additions, blocks, options.add, spread, options.repeats)


def _probes(present: _Present, options: PlanningOptions) -> Family | str:
    """Probes to add for all present speeds.

    Unplanned data are the whole run again, as much of it as the probes' data.
    """
    problem = present.problem
    sites = problem.sites
    if not options.sensors or not len(sites):
        reason = "study.sensors is 0" if not options.sensors else "the problem has no sites"
        return f"no probes are considered: {reason}"
    there = [item for item in problem.channels if item.is_1x]
    possible = [Channel(float(site), direction) for site in sites for direction in further_directions(there)]
    channels = [
        each
        for each in possible
        if not any(abs(each.position - item.position) < 1e-9 and each.is_parallel_to(item) for item in there)
    ]
    additions = [Addition(position=channel.position, direction=channel.direction) for channel in channels]
    present, blocks = _with_probes(present, channels)

    def again(count: int) -> Array:
        return present.data * math.sqrt(count / len(problem.channels))

    return _family(present, "probes", additions, blocks, options.sensors, again)


def _with_probes(present: _Present, channels: Sequence[Channel]) -> tuple[_Present, list[Array]]:
    """The present data and the data rows of each further probe.

    Numbers of several of these probes, such as the position of their plane, are further columns of both.
    """
    seen = present.problem.at(present.problem.speed, channels)
    new = Numbers.of(seen).beyond(present.numbers)
    rows = present.rows_of(seen, present.numbers + new)
    blocks = [_flat(rows[:, :, index]) for index in range(len(channels))]
    if not len(new) or not blocks:
        return present, blocks
    blocks, shared = own_numbers_as_noise(blocks, new.sd)
    common = Numbers(tuple(new.items[index] for index in shared))
    return dataclasses.replace(present, numbers=present.numbers + common), blocks


def _trial_run(present: _Present, options: PlanningOptions) -> Family | str:
    """A second run with a known unbalance at a site; without a plan, the same run again."""
    problem = present.problem
    if not problem.takes_unbalance:
        return "no trial run is considered: the problem takes no trial unbalance"
    sites = weight_positions(problem) if options.trial_sites is None else options.trial_sites
    if not len(sites) or not options.trial_phases:
        reason = "study.trial_phases is empty" if not options.trial_phases else "no site exists; give study.trial_sites"
        return f"no trial run is considered: {reason}"
    run = problem if problem.campaign is None else problem.at(problem.speed[problem.campaign.rows[0]], problem.channels)
    if options.trial_unbalance is None:
        magnitude = equal_unbalance(problem, present.x, sites)
    else:
        magnitude = options.trial_unbalance * GRAM_MILLIMETRE
    every = [(float(site), magnitude, phase * DEGREE) for site in sites for phase in options.trial_phases]
    present_motion = _largest_motion(run, present.x)
    trials = [each for each in every if _largest_motion(run.with_unbalance(*each), present.x) > STILL * present_motion]
    additions = [Addition(position=site, magnitude=size, phase=phase) for site, size, phase in trials]
    blocks = [_flat(present.of(run.with_unbalance(*trial))) for trial in trials]
    return _family(present, "trial run", additions, blocks, 1, lambda count: _flat(present.of(run)))


def _numbers(present: _Present, options: PlanningOptions) -> Family | str:
    """Numbers known to a tolerance that are measured until they are as good as exact.

    Unplanned data are the run again.
    """
    if not options.numbers:
        return "no numbers are considered: study.numbers is 0"
    numbers, n_column = present.numbers, present.rows.shape[1]
    weights = np.diag(EXACT / numbers.sd)
    blocks = [np.append(np.zeros(n_column - len(numbers)), row)[None] for row in weights]
    additions = [Addition(number=words) for words in numbers.words]
    return _family(present, "numbers", additions, blocks, options.numbers, lambda count: present.data)


def _largest_motion(problem: Problem, x: Array) -> float:
    """Over all speeds and channels, m."""
    return float(np.max(np.abs(problem.response(x[None]))))


def _family(
    present: _Present,
    name: str,
    additions: Sequence[Addition],
    blocks: Sequence[Array],
    count: int,
    unplanned: Callable[[int], Array],
    repeats: int = 1,
) -> Family | str:
    """Reduction by each addition alone, the stepwise choice, and the gain of unplanned data.

    There are as many `unplanned` data. `blocks` are the data rows (m, k) of each addition.
    """
    usable = [index for index, block in enumerate(blocks) if np.all(np.isfinite(block))]  # no motion, no amplitude
    additions, blocks = [additions[index] for index in usable], [blocks[index] for index in usable]
    if not blocks:
        return f"no {name} are considered: no candidate exists"
    before, each = information(present.rows), np.stack([information(block) for block in blocks])
    chosen = choose(before, each, min(count, repeats * len(blocks)), present.criterion, repeats)
    steps = []
    for n_chosen in range(1, len(chosen) + 1):
        planned = np.concatenate([present.rows, *(blocks[index] for index in chosen[:n_chosen])])
        without = np.concatenate([present.rows, _flat(unplanned(n_chosen))])
        steps.append(
            Step(
                candidate=chosen[n_chosen - 1],
                crlb=_listed(present.crlb_of(planned)),
                reduction_pct=present.reduction_pct(planned),
                unplanned_crlb=_listed(present.crlb_of(without)),
                unplanned_reduction_pct=present.reduction_pct(without),
                **vars(additions[chosen[n_chosen - 1]]),
            )
        )
    reduced = np.linalg.qr(present.rows, mode="r")  # the same information in k rows
    single = [np.concatenate([reduced, block]) for block in blocks]
    has_one_target = len(present.target) == 1
    candidates = Candidates(
        reduction_pct=tuple(present.reduction_pct(rows) for rows in single),
        criterion_reduction_pct=tuple(present.criterion.reduction_pct(before, before + each).tolist()),
        crlb=_listed(np.array([present.crlb_of(rows)[present.target[0]] for rows in single]))
        if has_one_target
        else None,
        **_columns(additions),
    )
    return Family(name, candidates, tuple(steps))


def _columns(additions: Sequence[Addition]) -> dict[str, Any]:
    """Additions column by column; None for a column that no addition has."""
    columns = {name: tuple(getattr(addition, name) for addition in additions) for name in vars(additions[0])}
    return {name: None if column[0] is None else column for name, column in columns.items()}


def _flat(rows: Array) -> Array:
    """Data rows (…, k) → (m, k)."""
    return rows.reshape(-1, rows.shape[-1])


def _listed(crlb: Array) -> tuple[float | None, ...]:
    return tuple(finite(value) for value in crlb)
