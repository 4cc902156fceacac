"""Responses of the three-disk rotor, their derivatives and its critical speeds, by this project."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count

import numpy as np

import ksmea
from benchmarks.harness.task import Task
from benchmarks.tasks.three_disk import N_COMPARED, TRUTH, drawn
from ksmea.plugins import registry
from ksmea.problem.problem import Problem
from problems.rotor.finite_elements.assembly import assemble_free, node_dof
from problems.rotor.finite_elements.loads import force_per_unbalance
from problems.rotor.response.dense import channel_rows, dynamic_stiffness
from problems.rotor.response.receptance import reduce_rotor
from problems.three_disk import ThreeDisk


def evaluations(n_speed: int, batch: int, mesh: int = 13) -> Task:
    """So many sets of unknowns at once."""
    problem = ThreeDisk(n_speed=n_speed, mesh=mesh).build()
    points = drawn(batch)
    return Task(
        lambda turn: problem.response(points), values=lambda _: problem.response(drawn(N_COMPARED)), units=batch
    )


def set_up(n_speed: int, mesh: int = 13) -> Task:
    """A problem from nothing, and its first response."""
    return Task(lambda turn: ThreeDisk(n_speed=n_speed, mesh=mesh).build().response(TRUTH[None]), values=_first)


def reduction(mesh: int) -> Task:
    """The rotor reduced to its ports anew, as an effect on the rotor itself makes it."""
    problem = ThreeDisk(mesh=mesh).build()
    impedances = problem.reduction.impedances
    return Task(
        lambda turn: reduce_rotor(problem.rotor, impedances, problem.speed, problem.channels),
        values=lambda found: found.receptance,
    )


def dense_reduction(mesh: int) -> Task:
    """Reduction by numpy's dense solver."""
    problem = ThreeDisk(mesh=mesh).build()
    rotor, speed, known = problem.rotor, problem.speed, problem.reduction
    ports = np.concatenate([node_dof(rotor.node_at(bearing.position, "bearing"))[:2] for bearing in rotor.bearings])

    def receptance(turn: int) -> np.ndarray:
        stiffness = dynamic_stiffness(assemble_free(rotor), speed)
        for item, values in zip(known.impedances, known.nominal):
            stiffness[:, ports[item.row_port], ports[item.column_port]] += values if item.is_direct else 0
        port_rows = np.eye(stiffness.shape[-1])[ports]
        at_ports = np.broadcast_to(port_rows.T, (len(speed), *port_rows.T.shape))
        forces = np.concatenate([at_ports, force_per_unbalance(rotor, speed)], axis=2)
        read = np.concatenate([port_rows, channel_rows(rotor, problem.channels)])
        return np.moveaxis(read @ np.linalg.solve(stiffness, forces), 0, 2)

    return Task(receptance, values=lambda found: found)


def sensitivity(effect: str = "") -> Task:
    """The response's derivatives by the unknowns and those of an effect, where one is named."""
    problem, points = extended(effect)
    return Task(lambda turn: problem.sensitivity(next(points)), values=_relative)


def differences(effect: str = "") -> Task:
    """Derivatives by central differences in one batch."""
    problem, points = extended(effect)

    def derivative(turn: int) -> np.ndarray:
        x = next(points)
        step = 1e-5 * np.abs(x)
        ahead, behind = np.split(problem.response(np.concatenate([x + np.diag(step), x - np.diag(step)])), 2)
        return np.moveaxis((ahead - behind) / (2 * step[:, None, None]), 0, -1)

    return Task(derivative, values=_relative)


def _relative(sensitivity: np.ndarray) -> np.ndarray:
    """By each unknown, over its largest: unknowns have units of their own."""
    return sensitivity / np.max(np.abs(sensitivity), axis=(0, 1))


def extended(effect: str) -> tuple[Problem, Iterator[np.ndarray]]:
    """The rotor with an effect of its own scale, and where it is linearised (d,).

    Somewhere else at each call, since what was asked for last is kept.
    """
    problem: Problem = ThreeDisk().build()
    x = TRUTH
    if effect:
        problem = registry.create("effect", effect, {}).added_to(problem)
        lower, upper = problem.parameters.lower[5:], problem.parameters.upper[5:]
        x = np.append(TRUTH, lower + 0.6 * (upper - lower))
    return problem, (x * (1 + 1e-6 * number) for number in count())


def critical_speeds() -> Task:
    """Critical speeds below the highest speed, rad/s, with other bearings at each call."""
    rotor = ksmea.load_problem("three_disk")
    values = ({name: value * (1 + 1e-6 * number) for name, value in rotor.reference.items()} for number in count())
    return Task(lambda turn: rotor.critical_speeds(next(values)), values=lambda found: found)


def _first(response: np.ndarray) -> np.ndarray:
    """The response to the published values, (n_speed, 2): all sides have it."""
    return response[0]
