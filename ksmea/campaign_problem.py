"""A machine seen in all runs of a campaign: each run at its own speeds and with its known weights.

All unknowns are shared but those of which the campaign says that each run has its own: these are named `name@run`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.campaign import Campaign, Run, Weight, own_name
from ksmea.channel import Channel
from ksmea.contracts import Problem
from ksmea.errors import SettingError, unknown
from ksmea.load import Load
from ksmea.modes import Campbell, Mode
from ksmea.parameters import PHASE_ORIGIN, Parameters
from ksmea.units import GRAM_MILLIMETRE

LARGEST_WEIGHT = 1000.0  # times the largest unbalance that the model may have; more is a slip or another unit


def in_runs(machine: Problem, campaign: Campaign) -> CampaignProblem:
    """A machine, seen at the speeds of all runs one after the other, as the campaign saw it.

    Raises `SettingError` where it takes a weight of no run, or lacks an unknown that each run has of its own.
    """
    for run in campaign.runs:
        _check_weights(machine, run)
    for name in campaign.own:
        if name not in (*machine.parameters.names, PHASE_ORIGIN):
            raise unknown("unknown in own:", name, machine.parameters.names)
    return CampaignProblem(machine, campaign)


def _check_weights(machine: Problem, run: Run) -> None:
    """Raise `SettingError` for a weight that the machine cannot carry."""
    largest = LARGEST_WEIGHT * max((item.upper for item in machine.parameters if item.is_unbalance), default=np.inf)
    for weight in run.weights:
        if weight.magnitude is None:
            raise SettingError(
                f"run {run.name}: expected weights of known size, got {weight}; give g_mm, or use study=balance"
            )
        if weight.magnitude > largest:
            raise SettingError(
                f"run {run.name}: expected weights up to {largest / GRAM_MILLIMETRE:g} g mm, {LARGEST_WEIGHT:g} times the"
                f" largest unbalance of the model, got {weight}; is it in g mm?"
            )
        try:
            machine.with_unbalance(weight.position, weight.magnitude, weight.angle)
        except SettingError as error:
            raise SettingError(f"run {run.name}, weight {weight}: {error}") from error


@dataclass(frozen=True, eq=False)
class CampaignProblem(Problem):
    """`base` is the machine at the speeds of all runs, without their weights: effects and texts are of it."""

    base: Problem
    campaign: Campaign

    @cached_property
    def parameters(self) -> Parameters:
        items = []
        for item in self.base.parameters:
            own = [own_name(item.name, run.name) for run in self.campaign.runs]
            names = own if self._is_own(item.name) else [item.name]
            items += [dataclasses.replace(item, name=name) for name in names]
        return Parameters(tuple(items))

    @property
    def speed(self) -> Array:
        return self.base.speed

    @property
    def channels(self) -> tuple[Channel, ...]:
        return self.base.channels

    def response(self, x: Array) -> ComplexArray:
        """(n, d) SI → (n, n_speed, n_channel), m."""
        return self._stacked(x, lambda problem, own: problem.response(own))

    def dense_response(self, x: Array) -> ComplexArray:
        return self._stacked(x, lambda problem, own: problem.dense_response(own))

    def load_response(self, x: Array, loads: Sequence[Load]) -> ComplexArray:
        return self._stacked(x, lambda problem, own: problem.load_response(own, loads))

    def sensitivity(self, x: Array) -> ComplexArray:
        """(d,) SI → ∂response/∂x, (n_speed, n_channel, d), m per SI unit."""
        found = np.zeros((len(self.speed), len(self.channels), len(self.parameters)), dtype=complex)
        for rows, columns, problem in self._seen:
            found[rows, :, columns] = problem.sensitivity(np.asarray(x)[columns])
        return found

    def at(self, speed: Array, channels: Sequence[Channel]) -> CampaignProblem:
        """As a further run without weights would see it; where runs have unknowns of their own, with those of the first."""
        runs = [dataclasses.replace(run, weights=()) for run in self.campaign.runs]
        further = dataclasses.replace(self.campaign, runs=tuple(runs))
        counts = [len(speed), *(0 for _ in runs[1:])]
        return CampaignProblem(self.base.at(speed, channels), further.with_counts(counts))

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

    def with_unbalance(self, position: float, magnitude: float, phase: float) -> CampaignProblem:
        """All runs again with one more weight."""
        return self.changed(lambda base: base.with_unbalance(position, magnitude, phase))

    @property
    def machine(self) -> Problem:
        return self.base

    def changed(self, change: Callable[[Problem], Problem]) -> CampaignProblem:
        return dataclasses.replace(self, base=change(self.base))

    @property
    def costly(self) -> Indices:
        return np.flatnonzero(np.isin(self._origin, self.base.costly))

    @property
    def sites(self) -> Array:
        return self.base.sites

    @property
    def landmarks(self) -> Mapping[str, float]:
        return self.base.landmarks

    @property
    def has_sensitivity(self) -> bool:
        return self.base.has_sensitivity

    @property
    def has_dense_route(self) -> bool:
        return self.base.has_dense_route

    @property
    def can_leave_phase_open(self) -> bool:
        return self.base.can_leave_phase_open

    @property
    def takes_unbalance(self) -> bool:
        return self.base.takes_unbalance

    @property
    def takes_loads(self) -> bool:
        return self.base.takes_loads

    @property
    def knows_stability(self) -> bool:
        return self.base.knows_stability

    def critical_speeds(self, x: Array, highest: float | None = None) -> Array:
        """Those of all runs, rising: where runs have unknowns of their own they differ."""
        return np.unique(np.concatenate([self.base.critical_speeds(each, highest) for each in self._distinct(x)]))

    def modes(self, x: Array, speed: float, n_mode: int | None = None) -> tuple[Mode, ...]:
        """Of the first run."""
        return self.base.modes(self._distinct(x)[0], speed, n_mode)

    def campbell(self, x: Array, speed: Array, n_mode: int = 6) -> Campbell:
        """Of the first run."""
        return self.base.campbell(self._distinct(x)[0], speed, n_mode)

    def growth_rate(self, x: Array, speed: Array) -> Array:
        """The largest of any run."""
        return np.asarray(np.max([self.base.growth_rate(each, speed) for each in self._distinct(x)], axis=0))

    @property
    def _weights(self) -> tuple[Weight, ...]:
        return tuple(weight for run in self.campaign.runs for weight in run.weights)

    def _is_own(self, name: str) -> bool:
        return name in self.campaign.own

    @cached_property
    def _origin(self) -> Indices:
        """Which unknown of the machine each unknown is."""
        counts = [len(self.campaign.runs) if self._is_own(name) else 1 for name in self.base.parameters.names]
        return np.repeat(np.arange(len(counts)), counts)

    def _columns(self, run: int) -> Indices:
        """Where the values of a run lie among the unknowns."""
        is_first = np.concatenate([[True], np.diff(self._origin) > 0])
        own = np.array([self._is_own(name) for name in self.base.parameters.names])
        return np.asarray(np.flatnonzero(is_first) + run * own)

    @cached_property
    def _seen(self) -> tuple[tuple[slice, Indices, Problem], ...]:
        """Rows, columns among the unknowns and the problem of each run that has speeds."""
        found = []
        for index, (run, rows) in enumerate(zip(self.campaign.runs, self.campaign.rows)):
            if run.n_speed:
                problem = self.base.at(self.speed[rows], self.channels)
                for weight in run.weights:
                    if weight.magnitude is not None:  # `in_runs` has refused the others
                        problem = problem.with_unbalance(weight.position, weight.magnitude, weight.angle)
                found.append((rows, self._columns(index), problem))
        return tuple(found)

    def _distinct(self, x: Array) -> list[Array]:
        """The values (d,) of the machine's unknowns in each run, each set once."""
        values = [np.asarray(x)[self._columns(index)] for index in range(len(self.campaign.runs))]
        return values if self.campaign.own else values[:1]

    def _stacked(self, x: Array, evaluate: Callable[[Problem, Array], ComplexArray]) -> ComplexArray:
        """What is evaluated of sets (n, d) run by run, (n, n_speed, …)."""
        x = np.asarray(x, dtype=float)
        if x.ndim != 2 or x.shape[1] != len(self.parameters):
            raise SettingError(
                f"parameter sets: expected an array (n, {len(self.parameters)}) in the order"
                f" {', '.join(self.parameters.names)}, got shape {x.shape}"
            )
        return np.concatenate([evaluate(problem, x[:, columns]) for _, columns, problem in self._seen], axis=1)
