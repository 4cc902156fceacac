"""Causes that a library of effects lacks, each at one place of a drawn machine.

Their data come from the dense route with four times as many elements: a cause is put into those matrices here, by no effect of the
library, or is balanced with harmonics 1, 3 and 5 and twice as many elements.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from benchmarks.acting import response_with
from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.channel import Channel
from ksmea.problem.load import Load
from problems.drawn import Drawn
from problems.drawn_kinds import N_ELEMENT
from problems.rotor.finite_elements.assembly import assemble
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.loads import unit_loads
from problems.rotor.response import dense
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.unknowns import rotor_at
from tests.helpers.harmonic_balance import balanced_response

N_STEP, NEAR = 10, 0.85  # steps of the size until the change is at most, and nearly, as wanted


@dataclass(frozen=True)
class Machine:
    """A drawn machine as a user states it, and finer ones that make the data.

    The finest is solved as dense matrices, the one between by harmonic balance.
    """

    problem: RotorProblem
    fine: RotorProblem
    coarser: RotorProblem
    x: Array  # (d,) SI

    @classmethod
    def drawn(cls, family: str, instance: int) -> Machine:
        settings = Drawn(family=family, instance=instance)
        problem, truth = settings.build(), settings.reference()
        fine, coarser = (replace(settings, mesh=times * N_ELEMENT).build() for times in (4, 2))
        return cls(problem, fine, coarser, np.array([truth[name] for name in problem.parameters.names]))

    @cached_property
    def rotor(self) -> Rotor:
        return rotor_at(self.fine.rotor, self.fine.unknowns, self.x)

    @cached_property
    def plain(self) -> ComplexArray:
        """Response (n_speed, n_channel), m, without the cause."""
        return dense.dense_response(self.rotor, self.fine.speed, self.fine.channels)

    def between(self, rng: np.random.Generator) -> float:
        """A site of the model between the outer bearings, m, that is none of them."""
        low, high = self.rotor.bearings[0].position, self.rotor.bearings[-1].position
        margin = 0.1 * (high - low)
        return float(rng.choice([each for each in self.problem.sites if low + margin < each < high - margin]))

    def disk(self, rng: np.random.Generator) -> float:
        return float(rng.choice([disk.position for disk in self.rotor.disks]))

    def bearing(self, rng: np.random.Generator) -> float:
        return float(rng.choice([bearing.position for bearing in self.rotor.bearings]))

    @property
    def middle_speed(self) -> float:
        return float(np.median(self.fine.speed))

    def acting(
        self,
        position: float,
        quantity: str = "force",
        load: ComplexArray | Array | int = 0,
        impedance: ComplexArray | Array | int = 0,
    ) -> ComplexArray:
        """Response with a load (n_speed, 2) at a place, N or N m, and an impedance (n_speed, 2, 2) there."""
        return response_with(self.rotor, self.fine.speed, self.fine.channels, position, quantity, load, impedance)

    def balanced(self, position: float, force_at: Callable[[Array, ComplexArray], Array]) -> ComplexArray:
        """Response with a force at a place that is not linear in the motion."""
        rotor = rotor_at(self.coarser.rotor, self.fine.unknowns, self.x)
        return np.asarray(balanced_response(rotor, self.fine.speed, self.fine.channels, position, force_at))

    def motion_at(self, position: float) -> Array:
        """Amplitude (n_speed,) m at a place without the cause."""
        both = dense.dense_response(self.rotor, self.fine.speed, [Channel(position, axis) for axis in "xy"])
        return np.linalg.norm(both, axis=1)


Sized = Callable[[float], ComplexArray]  # response at a size


@dataclass(frozen=True)
class Cause:
    """A cause at one place, its response by its size in SI, and a size to start from."""

    position: float
    sized: Sized
    start: float


def _static_stiffness(machine: Machine, position: float) -> float:
    """About as stiff, N/m, as the machine is at a place: the weight of a stiff support there."""
    rows = unit_loads(machine.rotor, [Load(position, "x", "force")], 1)[0][:, 0]
    stiffness = dense.dynamic_stiffness(assemble(machine.rotor), machine.fine.speed[:1])[0]
    return float(1 / abs(rows @ np.linalg.solve(stiffness, rows)))


def spring(machine: Machine, rng: np.random.Generator) -> Cause:
    """A spring to the ground between the bearings, twice as stiff along x."""
    place = machine.between(rng)
    return Cause(
        place,
        lambda size: machine.acting(place, impedance=size * np.diag([1.0, 0.5])),
        _static_stiffness(machine, place),
    )


def damper(machine: Machine, rng: np.random.Generator) -> Cause:
    """A damper to the ground between the bearings."""
    place, speed = machine.between(rng), machine.fine.speed[:, None, None]
    return Cause(
        place,
        lambda size: machine.acting(place, impedance=1j * speed * size * np.eye(2)),
        _static_stiffness(machine, place) / machine.middle_speed,
    )


def cross_coupled_disk(machine: Machine, rng: np.random.Generator) -> Cause:
    """Cross-coupled stiffness at a disk, as in a seal, with a damper that holds it stable."""
    place, speed = machine.disk(rng), machine.fine.speed[:, None, None]
    turned = np.array([[0, -1.0], [1.0, 0]])

    def sized(size: float) -> ComplexArray:
        damping = 1j * speed / machine.middle_speed * 1.5 * size * np.eye(2)
        return machine.acting(place, impedance=size * turned + damping)

    return Cause(place, sized, _static_stiffness(machine, place))


def pedestal(machine: Machine, rng: np.random.Generator) -> Cause:
    """A pedestal with a mass under one bearing alone; its natural frequency lies above the band."""
    place, speed = machine.bearing(rng), machine.fine.speed[:, None, None]
    bearing = next(each for each in machine.rotor.bearings if each.position == place)
    own = bearing.stiffness + 1j * speed * bearing.damping
    above = (1.5 * machine.fine.speed[-1]) ** 2

    def sized(size: float) -> ComplexArray:
        compliance = size / (1 + 0.04j - speed**2 / above)
        return machine.acting(place, impedance=np.linalg.solve(np.eye(2) + own * compliance, own) - own)

    return Cause(place, sized, 1 / float(np.mean(np.diag(bearing.stiffness))))


def absorber(machine: Machine, rng: np.random.Generator) -> Cause:
    """A mass on a spring with 5 % damping at a disk, which resonates in the band."""
    place, speed = machine.disk(rng), machine.fine.speed
    own = rng.uniform(0.9, 1.1) * machine.middle_speed
    dynamic = -(speed**2) * (own**2 + 0.1j * own * speed) / (own**2 + 0.1j * own * speed - speed**2)
    start = machine.rotor.disks[0].mass
    return Cause(place, lambda size: machine.acting(place, impedance=size * dynamic[:, None, None] * np.eye(2)), start)


def magnetic_pull(machine: Machine, rng: np.random.Generator) -> Cause:
    """A force that turns with the shaft and is as large at each speed, between the bearings."""
    place, turn = machine.between(rng), np.exp(2j * np.pi * rng.uniform())
    start = _static_stiffness(machine, place) * float(np.median(machine.motion_at(place)))
    return Cause(place, lambda size: machine.acting(place, load=size * turn * np.array([1, -1j])), start)


def tilting_spring(machine: Machine, rng: np.random.Generator) -> Cause:
    """A bearing that also resists tilting."""
    place = machine.bearing(rng)
    start = _static_stiffness(machine, place) * (0.1 * machine.rotor.length) ** 2
    return Cause(place, lambda size: machine.acting(place, "moment", impedance=size * np.eye(2)), start)


def hardening(machine: Machine, rng: np.random.Generator) -> Cause:
    """A cubic spring at a disk."""
    place = machine.disk(rng)
    start = _static_stiffness(machine, place) / float(np.max(machine.motion_at(place))) ** 2

    def sized(size: float) -> ComplexArray:
        return machine.balanced(place, lambda orbit, turn: -size * np.sum(orbit**2, axis=-1, keepdims=True) * orbit)

    return Cause(place, sized, 0.05 * start)


def stop(machine: Machine, rng: np.random.Generator) -> Cause:
    """A soft stop at a disk, beyond half of its largest motion."""
    place = machine.disk(rng)
    clearance = 0.5 * float(np.max(machine.motion_at(place)))

    def sized(size: float) -> ComplexArray:
        def force_at(orbit: Array, turn: ComplexArray) -> Array:
            return -size * np.maximum(1 - clearance / np.linalg.norm(orbit, axis=-1, keepdims=True), 0) * orbit

        return machine.balanced(place, force_at)

    return Cause(place, sized, 0.1 * _static_stiffness(machine, place))


def drag(machine: Machine, rng: np.random.Generator) -> Cause:
    """Quadratic damping at a disk, against its velocity at the running speed."""
    place = machine.disk(rng)
    largest = float(np.max(machine.motion_at(place)))

    def sized(size: float) -> ComplexArray:
        def force_at(orbit: Array, turn: ComplexArray) -> Array:
            velocity = (np.roll(orbit, -1, axis=0) - np.roll(orbit, 1, axis=0)) / (4 * np.pi / len(orbit))
            return -size * np.linalg.norm(velocity, axis=-1, keepdims=True) * velocity

        return machine.balanced(place, force_at)

    return Cause(place, sized, 0.1 * _static_stiffness(machine, place) / largest)


Maker = Callable[[Machine, np.random.Generator], Cause]
WITHOUT: dict[Maker, tuple[str, ...]] = {  # effects that can express the cause
    spring: ("annular_seal", "local_force", "bilinear_stiffness", "cubic_stiffness"),
    damper: ("annular_seal", "local_force"),
    cross_coupled_disk: ("annular_seal", "local_force"),
    pedestal: (
        "flexible_pedestal",
        "foundation_resonance",
        "unequal_bearings",
        "local_force",
    ),  # below its resonance softer
    absorber: ("spring_mass", "local_force"),
    magnetic_pull: ("local_force",),
    tilting_spring: ("local_force",),
    hardening: ("cubic_stiffness", "bilinear_stiffness", "local_force"),
    stop: ("clearance_rub", "bilinear_stiffness", "cubic_stiffness", "local_force"),
    drag: ("local_force",),
}
CAUSES = {maker.__name__: maker for maker in WITHOUT}


def of_change(machine: Machine, cause: Cause, change: float) -> ComplexArray:
    """The response with the cause, which changes it by a part of its rms, or less without a balance."""
    scale = np.sqrt(np.mean(np.abs(machine.plain) ** 2))
    low, high, best = 0.0, np.inf, machine.plain
    size = cause.start
    for _ in range(N_STEP):
        try:
            response = cause.sized(size)
            changed = np.sqrt(np.mean(np.abs(response - machine.plain) ** 2)) / scale
        except AssertionError:  # the motion folds over
            changed = np.inf
        if changed > change:
            high = size
        else:
            low, best = size, response
            if changed > NEAR * change:
                break
        size = 2 * size if high == np.inf else (low + high) / 2 if low else high / 4
    return best
