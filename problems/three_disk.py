"""The three-disk rotor of the reference paper, Table 1: Han, Guo & Gao, J. Sound Vib.

332 (2013) 2659–2671, doi 10.1016/j.jsv.2012.12.025. It is the example rotor of Lalanne & Ferraris, Rotordynamics
Prediction in Engineering (Wiley, 1998).

Two equal bearings without cross-coupling carry the shaft at its ends; their four coefficients and the unbalance on
the second disk are the unknowns.
"""

from __future__ import annotations

from dataclasses import dataclass

from ksmea.plugins.source import ProblemSettings
from ksmea.problem.parameters import Parameter
from ksmea.settings.settings import setting
from ksmea.units import GRAM_MILLIMETRE, RPM
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Rotor, UnbalancePlane
from problems.rotor.finite_elements.mesh import share_elements
from problems.rotor.finite_elements.segments import Disk, Material, ShaftSegment
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.unknowns import BearingTarget, Target, UnbalanceTarget, Unknown
from problems.rotor_settings import (
    FIVE_UNKNOWNS,
    band,
    channels_of,
    check_band,
    check_probes,
    check_size,
    limited_parameters,
)

PAPER = "Han, Guo & Gao 2013"
RAD_PER_S_PER_READING = {"rad_s": 1.0, "rpm": RPM}

STEEL = Material(young_modulus=200e9, density=7800.0, poisson_ratio=0.3)
SHAFT_RADIUS = 0.05  # m
SEGMENT_LENGTHS = (0.2, 0.3, 0.5, 0.3)  # m
SHAFT_LENGTH = sum(SEGMENT_LENGTHS)
DISK_POSITIONS = (0.2, 0.5, 1.0)  # m, the ends of the first three segments
DISK_OUTER_RADII = (0.12, 0.20, 0.20)  # m
DISK_INNER_RADIUS = 0.05  # m
DISK_THICKNESSES = (0.05, 0.05, 0.06)  # m
UNBALANCED_DISK = 1  # the second one

LIMITS = {"kxx": [10.0, 100.0], "kyy": [10.0, 100.0], "cxx": [0.01, 1.0], "cyy": [0.01, 1.0], "u": [50.0, 500.0]}


@dataclass(frozen=True)
class ThreeDisk(ProblemSettings):
    """The three-disk rotor on two equal bearings: four bearing coefficients and one unbalance are unknown."""

    mesh: int = setting(
        13,
        "number of shaft elements: 13 lie as 2/3/5/3 on the four segments, 21 as 3/5/8/5, any other count by length;"
        " the paper names 13 and 21 grids but not where the 21 lie",
        source=f"{PAPER}, section 4",
    )
    reading: str = setting(
        "rad_s",
        "how the paper's band of 200 to 1500 is read: it prints rpm, but then the response is quasi-static and the"
        " bearings cannot be seen; in rad/s four critical speeds lie inside and the published errors are reproduced",
        source=f"{PAPER}, section 4, and the Cramér–Rao lower bound of both readings",
        choices=tuple(RAD_PER_S_PER_READING),
    )
    speed_from: float = setting(200.0, "first speed, in the unit of `reading`", source=f"{PAPER}, section 4", above=0)
    speed_to: float = setting(1500.0, "last speed, in the unit of `reading`", source=f"{PAPER}, section 4", above=0)
    n_speed: int = setting(53, "number of equally spaced speeds; the paper names none, 53 step by 25", at_least=1)
    sensors: list[float] = setting(
        [0.1],
        "positions of the probes; the paper's 'second node' of 13 elements lies at 0.1 m, which is inside an element"
        " if there are 21: its shape functions interpolate there",
        unit="m",
        source=f"{PAPER}, section 4",
        at_least=0,
        at_most=SHAFT_LENGTH,
    )
    directions: list[str] = setting(
        ["x", "y"], "directions each probe measures, x or y; the paper does not say whether it used one or both"
    )
    limits: dict[str, list[float]] = setting(
        LIMITS,
        "lower and upper limit of each unknown; any that is not named keeps its default. The paper gives no limits:"
        " its results stick at these of c, 100 MN/m is the limit seen in its Table 8, limits of u are our choice",
        unit="MN/m, kN s/m, g mm",
        source=f"{PAPER}, Tables 3-6 and 8",
    )

    def check(self) -> None:
        check_size(self.mesh, self.n_speed)
        share_elements(self.mesh, SEGMENT_LENGTHS)
        check_band(self.speed_from, self.speed_to, self.n_speed)
        check_probes(self.sensors, self.directions)
        self._parameters()

    def build(self) -> RotorProblem:
        """The problem; its rotor carries no values of the unknowns."""
        return RotorProblem(
            rotor=three_disk_rotor(self.mesh),
            unknowns=tuple(Unknown(parameter, _targets(parameter.name)) for parameter in self._parameters()),
            speed=band(self.speed_from, self.speed_to, self.n_speed, RAD_PER_S_PER_READING[self.reading]),
            channels=channels_of(self.sensors, self.directions),
        )

    def reference(self) -> dict[str, float]:
        """The values of Table 1, SI."""
        return {"kxx": 50e6, "kyy": 70e6, "cxx": 500.0, "cyy": 700.0, "u": 200 * GRAM_MILLIMETRE}

    def _parameters(self) -> list[Parameter]:
        return limited_parameters(FIVE_UNKNOWNS, LIMITS, self.limits)


def three_disk_rotor(mesh: int) -> Rotor:
    """The rotor without the values of its unknowns: bearings and unbalance have their positions only."""
    counts = share_elements(mesh, SEGMENT_LENGTHS)
    return Rotor(
        segments=tuple(
            ShaftSegment(length, SHAFT_RADIUS, STEEL, n_element)
            for length, n_element in zip(SEGMENT_LENGTHS, counts, strict=True)
        ),
        disks=tuple(
            Disk.from_geometry(
                position,
                outer_radius=outer_radius,
                inner_radius=DISK_INNER_RADIUS,
                thickness=thickness,
                density=STEEL.density,
            )
            for position, outer_radius, thickness in zip(
                DISK_POSITIONS, DISK_OUTER_RADII, DISK_THICKNESSES, strict=True
            )
        ),
        bearings=(Bearing(0.0), Bearing(SHAFT_LENGTH)),
        unbalance=(UnbalancePlane(DISK_POSITIONS[UNBALANCED_DISK]),),
    )


def _targets(name: str) -> tuple[Target, ...]:
    """Target of an unknown: the unbalance, or a coefficient of both bearings."""
    if name == "u":
        return (UnbalanceTarget(0),)
    return (BearingTarget(0, name), BearingTarget(1, name))
