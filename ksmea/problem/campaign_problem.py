"""A machine seen in all runs of a campaign: each run at its own speeds and with its weights.

All unknowns are shared, except the ones that each run has of its own according to the campaign: these are named
`name@run`. The components of unknown weights come before them, so that what effects add is last, as on the machine
alone.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.errors import SettingError, unknown
from ksmea.measurement.campaign import Campaign, Run, Weight, own_name, shared_name, weight_names
from ksmea.measurement.channel import Channel
from ksmea.problem.forwarding import ProblemProxy
from ksmea.problem.load import Load
from ksmea.problem.parameters import PHASE_ORIGIN, Parameter, Parameters
from ksmea.problem.problem import Problem
from ksmea.rotordynamics.whirl import Campbell, Mode
from ksmea.units import GRAM_MILLIMETRE

LARGEST_WEIGHT = 1000.0  # times the largest unbalance that the model may have; more is a slip or another unit


def in_runs(machine: Problem, campaign: Campaign) -> CampaignProblem:
    """A machine, seen at the speeds of all runs one after the other, as the campaign saw it.

    Raises `SettingError` if it takes a weight of no run, or lacks an unknown that each run has of its own.
    """
    for run in campaign.runs:
        _check_units(campaign, run)
        _check_weights(machine, run)
    for name in campaign.own:
        if name not in (*machine.parameters.names, PHASE_ORIGIN):
            raise unknown("unknown in own:", name, machine.parameters.names)
    return CampaignProblem(machine, campaign)


def _check_units(campaign: Campaign, run: Run) -> None:
    """Raise `SettingError` for weights whose unbalance nobody knows.

    Masses without a radius, or in a unit of one's own.
    """
    for weight in run.all_weights:
        unit = campaign.plane(weight.position).unit
        if unit.scale:
            raise SettingError(
                f"run {run.name}: expected weights in kg m of unbalance for a rotor model, got {unit} at {weight.position:g} m; give"
                " radius in planes, or sizes such as 5 g @ 120 mm (+experiment=balance needs neither)"
            )


def _check_weights(machine: Problem, run: Run) -> None:
    """Raise `SettingError` for a weight that the machine cannot carry."""
    largest = LARGEST_WEIGHT * largest_unbalance(machine)
    for weight in run.weights:
        if weight.magnitude > largest:
            raise SettingError(
                f"run {run.name}: expected weights up to {largest / GRAM_MILLIMETRE:g} g mm, {LARGEST_WEIGHT:g} times the"
                f" largest unbalance of the model, got {weight}; is it in g mm?"
            )
        try:
            machine.with_unbalance(weight.position, weight.magnitude, weight.angle)
        except SettingError as error:
            raise SettingError(f"run {run.name}, weight {weight}: {error}") from error
    for number, sought in enumerate(run.unknown_weights, start=1):
        if sought.at_most is None and not np.isfinite(largest):
            raise SettingError(
                f"run {run.name}, {sought}: expected a model with an unknown unbalance, whose largest bounds the weight, got"
                " none; give at_most_g_mm"
            )
        try:
            machine.with_unknown_unbalance(sought.position, weight_names(run.name, number), sought.at_most or largest)
        except SettingError as error:
            raise SettingError(f"run {run.name}, {sought}: {error}") from error


def largest_unbalance(machine: Problem) -> float:
    """kg m, within the limits of the machine's unknowns; infinite where none of them is an unbalance."""
    return max((item.upper for item in machine.parameters if item.is_unbalance), default=np.inf)


@dataclass(frozen=True, eq=False)
class CampaignProblem(ProblemProxy):
    """Problem of a machine in the runs of a campaign.

    `base` is the machine at the speeds of all runs, without their weights: effects and texts are of it. The shaft
    carries no weights unless it `is_weighted`, though all unknowns are the same.
    """

    base: Problem
    seen_in: Campaign
    is_weighted: bool = True
    near: ComplexArray | None = None  # as of `next_to`

    @property
    def behind(self) -> Problem:
        return self.base

    def around(self, behind: Problem) -> CampaignProblem:
        return dataclasses.replace(self, base=behind, near=None)

    @property
    def machine(self) -> Problem:
        return self.base

    def changed(self, change: Callable[[Problem], Problem]) -> CampaignProblem:
        return self.around(change(self.base))

    @property
    def campaign(self) -> Campaign:
        return self.seen_in

    @cached_property
    def parameters(self) -> Parameters:
        largest, items = largest_unbalance(self.base), []
        for run in self.seen_in.runs:
            for number, weight in enumerate(run.unknown_weights, start=1):
                reach = weight.at_most or largest
                both = weight_names(run.name, number)
                items += [Parameter(name, "g mm", GRAM_MILLIMETRE, -reach, reach) for name in both]
        for item in self.base.parameters:
            own = [own_name(item.name, run.name) for run in self.seen_in.runs]
            names = own if self._is_own(item.name) else [item.name]
            items += [dataclasses.replace(item, name=name) for name in names]
        return Parameters(tuple(items))

    def next_to(self, motion: ComplexArray) -> CampaignProblem:
        return dataclasses.replace(self, near=motion)

    def response(self, x: Array) -> ComplexArray:
        """(n, d) SI → (n, n_speed, n_channel), m."""
        return self._stacked(x, lambda problem, own: problem.response(own))

    def dense_response(self, x: Array) -> ComplexArray:
        return self._stacked(x, lambda problem, own: problem.dense_response(own))

    def load_response(self, x: Array, loads: Sequence[Load]) -> ComplexArray:
        return self._stacked(x, lambda problem, own: problem.load_response(own, loads))

    def linearises_cheaply(self, loads: Sequence[Load] = ()) -> bool:
        return all(problem.linearises_cheaply(loads) for _, _, problem in self._seen)

    def sensitivity(self, x: Array) -> ComplexArray:
        """(d,) SI → ∂response/∂x, (n_speed, n_channel, d), m per SI unit."""
        return self.linearised(x)[1]

    def linearised(self, x: Array) -> tuple[ComplexArray, ComplexArray]:
        """Each run's own."""
        shape = len(self.speed), len(self.channels)
        response, sensitivity = np.empty(shape, complex), np.zeros((*shape, len(self.parameters)), complex)
        for rows, columns, problem in self._seen:
            response[rows], sensitivity[rows, :, columns] = problem.linearised(np.asarray(x)[columns])
        return response, sensitivity

    def linearised_per_load(self, x: Array, loads: Sequence[Load]) -> tuple[ComplexArray, ComplexArray]:
        """Each run's own."""
        shape = len(self.speed), len(self.channels), 1 + len(loads)
        columns, change = np.empty(shape, complex), np.zeros((*shape, len(self.parameters)), complex)
        for rows, own, problem in self._seen:
            columns[rows], change[rows, ..., own] = problem.linearised_per_load(np.asarray(x)[own], loads)
        return columns, change

    def at(self, speed: Array, channels: Sequence[Channel]) -> CampaignProblem:
        """The problem of a further run without weights.

        If runs have unknowns of their own, with the unknowns of the first.
        """
        counts = [len(speed), *(0 for _ in self.seen_in.runs[1:])]
        return CampaignProblem(self.base.at(speed, channels), self.seen_in.with_counts(counts), is_weighted=False)

    @property
    def has_free_phase(self) -> bool:
        """Not where only the unbalance has unknown phases: the angles of weights are known."""
        return self.base.has_free_phase and (not self._weights or PHASE_ORIGIN in self.base.parameters.names)

    def with_phase_origin(self) -> CampaignProblem:
        if self.has_free_phase:
            return self
        if not self.base.has_free_phase:
            return self.changed(lambda base: base.with_phase_origin())
        # With a weight of no size the machine itself has not all of its phases free.
        position = self._weights[0].position
        return self.changed(lambda base: base.with_unbalance(position, 0.0, 0.0).with_phase_origin())

    @property
    def costly(self) -> Indices:
        costly = [self.base.parameters.names[index] for index in self.base.costly]
        return np.flatnonzero([shared_name(name) in costly for name in self.parameters.names])

    def unbalance(self, x: Array) -> Mapping[float, complex]:
        """Unbalance in the first run, without weights."""
        return self.base.unbalance(self._distinct(x)[0])

    stability_threshold = Problem.stability_threshold  # by its own growth rate
    is_stable = Problem.is_stable

    def critical_speeds(self, x: Array, highest: float | None = None) -> Array:
        """Critical speeds of all runs, rising; they differ if runs have unknowns of their own."""
        return np.unique(np.concatenate([self.base.critical_speeds(each, highest) for each in self._distinct(x)]))

    def modes(self, x: Array, speed: float, n_mode: int | None = None) -> tuple[Mode, ...]:
        """Modes in the first run."""
        return self.base.modes(self._distinct(x)[0], speed, n_mode)

    def campbell(self, x: Array, speed: Array, n_mode: int = 6) -> Campbell:
        """Campbell diagram of the first run."""
        return self.base.campbell(self._distinct(x)[0], speed, n_mode)

    def growth_rate(self, x: Array, speed: Array) -> Array:
        """The largest of any run."""
        return np.asarray(np.max([self.base.growth_rate(each, speed) for each in self._distinct(x)], axis=0))

    @property
    def _weights(self) -> tuple[Weight, ...]:
        return tuple(weight for run in self.seen_in.runs for weight in run.weights)

    def _is_own(self, name: str) -> bool:
        return name in self.seen_in.own

    def _columns(self, run: Run, names: Sequence[str]) -> Indices:
        """Where unknowns of a run, as the machine names them, lie among all."""
        everyone = self.parameters.names
        own = [own_name(name, run.name) if self._is_own(name) else name for name in names]
        return np.array([everyone.index(name) for name in own], dtype=int)

    @cached_property
    def _seen(self) -> tuple[tuple[slice, Indices, Problem], ...]:
        """Rows, columns among the unknowns and the problem of each run that has speeds."""
        found = []
        for run, rows in zip(self.seen_in.runs, self.seen_in.rows):
            if run.n_speed:
                problem = self._weighted(self.base.going(run).at(self.speed[rows], self.channels), run)
                seen = problem if self.near is None else problem.next_to(self.near[rows])
                found.append((rows, self._columns(run, problem.parameters.names), seen))
        return tuple(found)

    def _weighted(self, problem: Problem, run: Run) -> Problem:
        """The machine with the weights of a run."""
        if not self.is_weighted:
            return problem
        for weight in run.weights:
            problem = problem.with_unbalance(weight.position, weight.magnitude, weight.angle)
        largest = largest_unbalance(self.base)
        for number, sought in enumerate(run.unknown_weights, start=1):
            names = weight_names(run.name, number)
            problem = problem.with_unknown_unbalance(sought.position, names, sought.at_most or largest)
        return problem

    def _distinct(self, x: Array) -> list[Array]:
        """The values (d,) of the machine's unknowns in each run, each set once."""
        names = self.base.parameters.names
        values = [np.asarray(x)[self._columns(run, names)] for run in self.seen_in.runs]
        return values if self.seen_in.own else values[:1]

    def _stacked(self, x: Array, evaluate: Callable[[Problem, Array], ComplexArray]) -> ComplexArray:
        """Results of `evaluate` for sets (n, d), run by run, (n, n_speed, …)."""
        x = np.asarray(x, dtype=float)
        if x.ndim != 2 or x.shape[1] != len(self.parameters):
            raise SettingError(
                f"parameter sets: expected an array (n, {len(self.parameters)}) in the order"
                f" {', '.join(self.parameters.names)}, got shape {x.shape}"
            )
        return np.concatenate([evaluate(problem, x[:, columns]) for _, columns, problem in self._seen], axis=1)
