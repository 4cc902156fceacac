"""Planning of measurements: which speeds, probes or trial unbalance to add so that the unknowns become known best.

The plan holds near the values that it is made for: the published ones, or measurement.truth.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from bench.plan.draw import Draw
from bench.plan.setup import Setup
from bench.plan.study import Study
from ksmea.arrays import Array
from ksmea.channel import Channel
from ksmea.contracts import Problem
from ksmea.errors import SettingError, unknown
from ksmea.parameters import Parameters
from ksmea.planning import Criterion, choose, crlb, data_rows, information, mean_axis_reduction_pct
from ksmea.settings import setting
from ksmea.units import DEGREE, GRAM_MILLIMETRE


@dataclass(frozen=True)
class Planning(Study):
    """Speeds, probes or a trial unbalance to add, chosen so that one unknown (c-optimal) or all of them (D-optimal) become
    known best; beside it what the same amount of data gives without a plan."""

    report: ClassVar[str] = "plan"
    ignores: ClassVar[tuple[str, ...]] = ("samples", "surrogate", "optimizer", "method")

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
        None, "where a trial unbalance may sit; null: at any of the problem's sites", unit="m", at_least=0
    )
    trial_phases: list[float] = setting(
        [0.0, 90.0, 180.0, 270.0], "phases that it may have; an empty list: no trial run is considered", unit="deg"
    )

    def check(self) -> None:
        if len(self.band) != 2:
            raise SettingError(f"band: expected two numbers, got {list(self.band)}")
        if self.add > self.n_candidate * self.repeats:
            raise SettingError(
                f"add: expected at most n_candidate × repeats = {self.n_candidate * self.repeats} speeds, got {self.add}"
            )

        if not (self.add or self.sensors or self.trial_phases):
            raise SettingError("add, sensors, trial_phases: expected something to add, got 0, 0 and no phase")

    def validate(self, setup: Setup) -> None:
        names = setup.problem.parameters.names
        if self.target is not None and self.target not in names:
            raise unknown("parameter in study.target:", self.target, names)
        setup.require_truth("study=plan")
        measurement = setup.plugins["measurement"]
        if measurement.noise is None or measurement.noise.is_absent:
            raise SettingError(
                "study=plan: expected a measurement with noise, without which every unknown is known exactly, got none;"
                " give measurement.relative or measurement.floor"
            )
        lowest, highest = self._limits(setup.problem)
        if lowest >= highest and self.add:
            raise SettingError(
                f"band: expected room for speeds, got {lowest:g} to {highest:g} rad/s; give [lower, upper] factors"
            )
        if setup.problem.takes_unbalance:
            for position in self.trial_sites or []:
                try:
                    setup.problem.with_unbalance(position, GRAM_MILLIMETRE, 0.0)
                except SettingError as error:
                    raise SettingError(f"study.trial_sites: {error}") from error

    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        problem, measurement = setup.problem, setup.plugins["measurement"]
        parameters, x = problem.parameters, setup.true_x
        noise, kind, noise_known = measurement.noise, measurement.kind, measurement.noise_known

        def rows_of(problem: Problem) -> Array:
            return data_rows(problem, x, noise, kind, noise_known=noise_known)

        sought = range(len(parameters)) if self.target is None else [parameters.names.index(self.target)]
        present = _Present(problem, x, rows_of, Criterion(tuple(sought)))
        families, remarks = [], []
        for family in (self._speeds, self._probes, self._trial_run):
            found = family(present)
            (remarks if isinstance(found, str) else families).append(found)
        if noise.floor == 0:
            remarks.append(
                "the noise is proportional to each value: places and speeds of hardly any motion count like all others;"
                " measurement.floor says what the probes resolve"
            )
        return {
            "status": "done",
            "target": self.target,
            "parameters": [
                {
                    "name": item.name,
                    "unit": item.unit,
                    "si_per_unit": item.si_per_unit,
                    "true": float(value),
                    "range_sd": (item.upper - item.lower) / math.sqrt(12),  # of a value drawn evenly between the bounds
                }
                for item, value in zip(parameters, x)
            ],
            "speed": [float(np.min(problem.speed)), float(np.max(problem.speed)), len(problem.speed)],
            "bound": _listed(present.bound),
            "families": families,
            "remarks": remarks,
        }

    def _speeds(self, present: _Present) -> dict[str, Any] | str:
        """Speeds to add for all present channels; without a plan, as many in the middle of equal parts of the band."""
        if not self.add:
            return "no speeds are considered: study.add is 0"
        problem = present.problem
        lowest, highest = np.min(problem.speed), np.max(problem.speed)
        speed = np.linspace(*self._limits(problem), self.n_candidate)
        rows = present.rows_of(problem.at(speed, problem.channels))

        def spread(count: int) -> Array:
            evenly = lowest + (highest - lowest) * (np.arange(count) + 0.5) / count
            return present.rows_of(problem.at(evenly, problem.channels))

        candidates = [{"speed": float(value)} for value in speed]
        blocks = [_flat(rows[:, place]) for place in range(len(speed))]
        return present.family("speeds", candidates, blocks, self.add, spread, self.repeats)

    def _probes(self, present: _Present) -> dict[str, Any] | str:
        """Probes to add for all present speeds; without a plan, the whole run again, as much of it as the probes' data."""
        problem = present.problem
        sites = problem.sites
        if not self.sensors or not len(sites):
            return (
                f"no probes are considered: {'study.sensors is 0' if not self.sensors else 'the problem has no sites'}"
            )
        there = {(round(channel.position, 9), channel.direction) for channel in problem.channels}
        channels = [
            Channel(float(site), direction)
            for site in sites
            for direction in ("x", "y")
            if (round(float(site), 9), direction) not in there
        ]
        rows = present.rows_of(problem.at(problem.speed, channels))
        candidates = [{"position": channel.position, "direction": channel.direction} for channel in channels]
        blocks = [_flat(rows[:, :, place]) for place in range(len(channels))]

        def again(count: int) -> Array:
            return present.rows * math.sqrt(count / len(problem.channels))

        return present.family("probes", candidates, blocks, self.sensors, again)

    def _trial_run(self, present: _Present) -> dict[str, Any] | str:
        """A second run with a known unbalance at a site; without a plan, the same run again."""
        problem = present.problem
        if not problem.takes_unbalance:
            return "no trial run is considered: the problem takes no trial unbalance"
        sites = problem.sites if self.trial_sites is None else np.array(self.trial_sites)
        if not len(sites) or not self.trial_phases:
            reason = (
                "study.trial_phases is empty" if not self.trial_phases else "there is no site; give study.trial_sites"
            )
            return f"no trial run is considered: {reason}"
        magnitude = present.equal_unbalance(sites) if self.trial_unbalance is None else self.trial_unbalance
        candidates = [
            {"position": float(site), "magnitude": magnitude * GRAM_MILLIMETRE, "phase": phase * DEGREE}
            for site in sites
            for phase in self.trial_phases
        ]
        blocks = [_flat(present.rows_of(problem.with_unbalance(**candidate))) for candidate in candidates]
        return present.family("trial run", candidates, blocks, 1, lambda count: present.rows)

    def _limits(self, problem: Problem) -> tuple[float, float]:
        """Lowest and highest candidate speed, rad/s."""
        return float(self.band[0] * np.min(problem.speed)), float(self.band[1] * np.max(problem.speed))


class _Present:
    """What the present data tell, and how much better each addition makes it."""

    def __init__(self, problem: Problem, x: Array, rows_of: Callable[[Problem], Array], criterion: Criterion) -> None:
        self.problem = problem
        self.x = x
        self.parameters: Parameters = problem.parameters
        self.rows_of = rows_of
        self.criterion = criterion
        self.rows = _flat(rows_of(problem))  # (m, k)
        self.bound = self._bound(self.rows)  # (d,) SI

    def family(
        self,
        name: str,
        candidates: Sequence[dict[str, Any]],
        blocks: Sequence[Array],
        count: int,
        unplanned: Callable[[int], Array],
        repeats: int = 1,
    ) -> dict[str, Any] | str:
        """The record of a family: the gain of each candidate alone, and step by step the choice and what as many
        `unplanned` data give."""
        usable = [place for place, block in enumerate(blocks) if np.all(np.isfinite(block))]  # no motion, no amplitude
        candidates, blocks = [candidates[place] for place in usable], [blocks[place] for place in usable]
        if not blocks:
            return f"no {name} are considered: there is no candidate"
        present, each = information(self.rows), np.stack([information(block) for block in blocks])
        chosen = choose(present, each, min(count, repeats * len(blocks)), self.criterion, repeats)
        steps = []
        for n_chosen in range(1, len(chosen) + 1):
            planned = np.concatenate([self.rows, *(blocks[place] for place in chosen[:n_chosen])])
            without = np.concatenate([self.rows, _flat(unplanned(n_chosen))])
            steps.append(
                {
                    "candidate": chosen[n_chosen - 1],
                    **candidates[chosen[n_chosen - 1]],
                    "bound": _listed(self._bound(planned)),
                    "gain_pct": self._gain_pct(planned),
                    "unplanned_bound": _listed(self._bound(without)),
                    "unplanned_gain_pct": self._gain_pct(without),
                }
            )
        columns = {key: [candidate[key] for candidate in candidates] for key in candidates[0]}
        reduced = np.linalg.qr(self.rows, mode="r")  # tells the same in k rows
        single = [np.concatenate([reduced, block]) for block in blocks]
        columns["gain_pct"] = [self._gain_pct(rows) for rows in single]
        columns["criterion_gain_pct"] = self.criterion.reduction_pct(present, present + each).tolist()
        if len(self.criterion.targets) == 1:
            columns["bound"] = _listed(np.array([self._bound(rows)[self.criterion.targets[0]] for rows in single]))
        return {"family": name, "candidates": columns, "steps": steps}

    def equal_unbalance(self, sites: Array) -> float:
        """The unbalance (g mm, two digits) that makes as much vibration as there is, rms, at the site where it makes most."""
        response = self.problem.response(self.x[None])[0]
        unit = [
            self.problem.with_unbalance(float(site), GRAM_MILLIMETRE, 0.0).response(self.x[None])[0] - response
            for site in sites
        ]
        ratio = np.linalg.norm(response) / max(np.linalg.norm(change) for change in unit)
        return float(f"{ratio:.1e}")

    def _bound(self, rows: Array) -> Array:
        return crlb(rows, len(self.parameters)) * self.parameters.width

    def _gain_pct(self, rows: Array) -> float | None:
        """How many per cent the bound falls, without any prior; None where something becomes known that was not at all."""
        bound, sought = self._bound(rows), list(self.criterion.targets)
        if np.any(np.isinf(self.bound[sought]) != np.isinf(bound[sought])):
            return None
        if len(sought) > 1:
            return mean_axis_reduction_pct(self.rows, rows, len(self.parameters))
        before, after = self.bound[sought[0]], bound[sought[0]]
        return 0.0 if np.isinf(before) else float(100 * (1 - after / before))


def _flat(rows: Array) -> Array:
    """Data rows (…, k) → (m, k)."""
    return rows.reshape(-1, rows.shape[-1])


def _listed(bound: Array) -> list[float | None]:
    """JSON has no infinity: what is not known is null."""
    return [float(value) if math.isfinite(value) else None for value in bound]
