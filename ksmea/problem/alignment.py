"""Problem aligned with a measurement: its speeds, runs, channels, harmonics and origin of phases.

A comparison takes the problem from here, because a response at other speeds has the right shape and the wrong values.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Layout, Measurement
from ksmea.problem.campaign_problem import CampaignProblem, in_runs
from ksmea.problem.problem import Problem

SAME_SPEED = 1e-9  # relative: rounding on the way through units and files
TRY = "make the problem with ksmea.problem.alignment.aligned(problem, measurement)"


def aligned(problem: Problem, measured: Measurement | Layout) -> Problem:
    """Return the problem at the speeds and channels of a measurement and in its runs.

    Its phase origin is unknown if the phase origin of the data is.

    Raises `SettingError` if the problem lacks something to be compared with data, or cannot be evaluated like the
    measurement: a channel or a weight lies off its shaft, or it cannot leave the phase origin open.
    """
    if problem.missing:
        raise SettingError(
            f"problem: expected {', '.join(problem.missing)}, got none; add them to the rotor file (docs/own_rotor.md), or draw the"
            " rotor without: python -m bench draw"
        )
    layout = measured.layout if isinstance(measured, Measurement) else measured
    if not layout.channels:
        raise SettingError(f"{layout.source}: expected at least one probe, got none; add probes to the rotor file")
    has_speeds = np.array_equal(problem.speed, layout.speed) and problem.campaign == layout.campaign
    if not (has_speeds and tuple(problem.channels) == tuple(layout.channels)):
        problem = _seen(problem, layout)
    if not layout.has_free_phase or problem.has_free_phase:
        return problem
    if not problem.can_leave_phase_open:
        raise SettingError(
            f"{layout.source}: phases were measured from an unknown origin, expected a problem that can leave it open, got"
            f" {type(problem).__name__}; use the amplitudes alone, or say that the origin is known"
        )
    return problem.with_phase_origin()


def through(problem: Problem, channels: Sequence[Channel]) -> Problem:
    """The problem at its speeds, and in its runs, through other channels."""
    return problem.changed(lambda machine: machine.at(machine.speed, channels))


def require_aligned(problem: Problem, measurement: Measurement) -> None:
    """Raise `SettingError` if a problem is not seen as the measurement.

    Another number of speeds or channels, a speed (beyond rounding) or a channel that differs, other runs, or a phase
    origin that is unknown in the data alone.
    """
    _require_speeds(problem.speed, measurement.speed)
    if problem.campaign != measurement.campaign:
        raise SettingError(
            f"runs: expected {measurement.campaign or 'one run'} as measured, got a problem seen in"
            f" {problem.campaign or 'one run'}; {TRY}"
        )
    if len(problem.channels) != len(measurement.channels):
        raise SettingError(
            f"channels: expected the {len(measurement.channels)} of the measurement, got a problem with"
            f" {len(problem.channels)}; {TRY}"
        )
    for number, (own, measured) in enumerate(zip(problem.channels, measurement.channels), start=1):
        if own != measured:
            raise SettingError(f"channel {number}: expected {measured} as measured, got a problem seen in {own}; {TRY}")
    if measurement.layout.has_free_phase and not problem.has_free_phase:
        raise SettingError(
            "phases: expected a problem with an unknown phase origin, as the measurement has, got one without"
            f" phase_origin among its unknowns; {TRY}"
        )


def _require_speeds(own: Array, measured: Array) -> None:
    if len(own) != len(measured):
        raise SettingError(
            f"speeds: expected the {len(measured)} of the measurement, got a problem with {len(own)}; {TRY}"
        )
    apart = np.flatnonzero(np.abs(own - measured) > SAME_SPEED * np.abs(measured))
    if len(apart):
        first = apart[0]
        raise SettingError(
            f"speed {first + 1}: expected {measured[first]:.10g} rad/s as measured, got a problem at"
            f" {own[first]:.10g} rad/s; {TRY}"
        )


def _seen(problem: Problem, layout: Layout) -> Problem:
    """The problem at other speeds and channels.

    An error says which channel cannot be, and where it stands.
    """
    try:
        return _in_its_runs(problem, layout)
    except SettingError as error:
        for channel, location in zip(layout.channels, layout.locations):
            try:
                problem.at(layout.speed, (channel,))
            except SettingError as own:
                raise SettingError(f"{location}: {own}") from own
        raise SettingError(f"{layout.source}: {error}") from error


def _in_its_runs(problem: Problem, layout: Layout) -> Problem:
    if problem.campaign is None and layout.campaign is None:
        return problem.at(layout.speed, layout.channels)
    machine = problem.machine.at(layout.speed, layout.channels)
    if layout.campaign is None:
        return machine
    if layout.campaign.weight_names and layout.kind != "complex":
        raise SettingError(
            "weights: expected phases, without which the angle of an unknown weight is not known, got amplitudes; give the"
            " weight's g_mm and angle_deg, or measure phases"
        )
    return in_runs(machine, layout.campaign) if problem.campaign is None else CampaignProblem(machine, layout.campaign)
