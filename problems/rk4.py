"""The Bently Nevada RK-4 rig of the reference paper, Table 7: Han, Guo & Gao, J. Sound Vib.

332 (2013) 2659–2671, doi 10.1016/j.jsv.2012.12.025.

One disk halfway between two ball bearings on a slender shaft. The table gives a length of 320 mm and an overhung
length of 120 mm, but neither where the overhang lies nor what the 320 mm span, nor the disk's size. With the
reference stiffness the first critical speed is, by this model,

    layout     between bearings  overhang  first critical
    span_320   320 mm            120 mm    4386 rpm
    span_440   440 mm            none      2718 rpm
    span_200   200 mm            120 mm    8682 rpm

and on rigid supports at most 0.4 % higher: 28 MN/m is 185 times the stiffness 48EI/L³ of a 320 mm span. The band of
1500 to 2500 rpm lies below the critical speed in each layout, so the bearings are all but invisible in it. It can
only be meant in rpm: the rig's top speed is 10 000 rpm.

z runs from the first bearing; an overhang lies beyond the second one. With the overhang before the first bearing
the rotor is the mirror image, and a probe lies as far from the other bearing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ksmea.errors import SettingError
from ksmea.plugins.source import ProblemSettings
from ksmea.problem.parameters import Parameter
from ksmea.settings.settings import setting
from ksmea.units import GRAM_MILLIMETRE, RPM
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Rotor, UnbalancePlane
from problems.rotor.finite_elements.mesh import uniform_shaft, weighed_ring
from problems.rotor.finite_elements.segments import Material
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
GIGAPASCAL = 1e9  # Pa

DENSITY, POISSON_RATIO = 7850.0, 0.3  # kg/m³
SHAFT_RADIUS = 0.005  # m
DISK_MASS = 0.583  # kg
OVERHANG = 0.12  # m
LAYOUTS = {"span_320": (0.32, OVERHANG), "span_440": (0.44, 0.0), "span_200": (0.2, OVERHANG)}  # span, overhang: m

# The longest element, m, that puts nodes at the bearings, the disk and the ends in each of the layouts.
ELEMENT_LENGTH = 0.02

LIMITS = {"kxx": [10.0, 100.0], "kyy": [10.0, 100.0], "cxx": [0.1, 10.0], "cyy": [0.1, 10.0], "u": [20.0, 200.0]}
TARGETS: dict[str, tuple[Target, ...]] = {  # what each unknown sets; both bearings alike
    **{name: (BearingTarget(0, name), BearingTarget(1, name)) for name in ("kxx", "kyy", "cxx", "cyy")},
    "u": (UnbalanceTarget(0),),
}

# N s/m. No damping is published; what Table 8 identifies lies between 0.1 and 10 kN s/m, and this is halfway in ratio.
ASSUMED_DAMPING = 1000.0


@dataclass(frozen=True)
class RK4(ProblemSettings):
    """The RK-4 rig of Table 7 on two equal bearings.

    Four bearing coefficients and the disk's unbalance are unknown.
    """

    layout: str = setting(
        "span_320",
        "what the printed 320 mm and the overhang of 120 mm are: span_320 has 320 mm between the bearings and the"
        " overhang beyond one of them, span_440 has their sum between the bearings, span_200 has 320 mm in all;"
        " the first critical speed is near 4400, 2700 and 8700 rpm",
        source=f"{PAPER}, Table 7",
        choices=tuple(LAYOUTS),
    )
    disk_diameter: float = setting(
        76.0,
        "diameter of the disk, not in the paper, from another RK-4 rig whose owners published it;"
        " from 50 to 100 mm the first critical speed changes by less than 0.02 %",
        unit="mm",
        above=2e3 * SHAFT_RADIUS,
    )
    disk_thickness: float | None = setting(
        None,
        "thickness of the disk, which sets its inertias and not its mass of 0.583 kg; null: as solid as the shaft,"
        " 16.7 mm at the default diameter",
        unit="mm",
        above=0,
    )
    young_modulus: float = setting(
        210.0, "Young's modulus; the paper prints 210 MPa and must mean GPa", unit="GPa", source=PAPER, above=0
    )
    mesh: int | None = setting(
        None,
        "number of shaft elements, shared by length between bearings, disk and ends; null: elements of 20 mm (22 or,"
        " for span_200, 16), the longest that fit each layout evenly. The paper's mesh is in a figure only",
        at_least=1,
    )
    speed_from: float = setting(1500.0, "first speed", unit="rpm", source=f"{PAPER}, section 6", above=0)
    speed_to: float = setting(2500.0, "last speed", unit="rpm", source=f"{PAPER}, section 6", above=0)
    n_speed: int = setting(41, "number of equally spaced speeds; the paper names none, 41 step by 25", at_least=1)
    sensors: list[float] = setting(
        [0.1],
        "positions of the probes, from the first bearing. The paper's '6th node' lies at 100 mm when the nodes are"
        " counted from 1 at that bearing and are 20 mm apart; there the disk is in layout span_200",
        unit="m",
        source=f"{PAPER}, section 6",
        at_least=0,
    )
    directions: list[str] = setting(
        ["x", "y"],
        "directions each probe measures, x (horizontal) or y (vertical)",
        source=f"{PAPER}, section 6.1: two sensors",
    )
    limits: dict[str, list[float]] = setting(
        LIMITS,
        "lower and upper limit of each unknown; any that is not named keeps its default. The paper gives none: its"
        " Table 8 sticks at k = 100 MN/m and c = 0.1 and 10 kN s/m; 10 MN/m and the limits of u are our choice",
        unit="MN/m, kN s/m, g mm",
        source=f"{PAPER}, Table 8",
    )

    def check(self) -> None:
        check_size(self.mesh or 1, self.n_speed)
        check_band(self.speed_from, self.speed_to, self.n_speed)
        check_probes(self.sensors, self.directions)
        length = sum(LAYOUTS[self.layout])
        for position in self.sensors:
            if position > length:
                raise SettingError(
                    f"sensors: expected positions up to {length:g} m, the shaft's length in layout {self.layout},"
                    f" got {position:g}"
                )
        self._parameters()
        self._rotor()

    def build(self) -> RotorProblem:
        """The problem; its rotor carries no values of the unknowns."""
        return RotorProblem(
            rotor=self._rotor(),
            unknowns=tuple(Unknown(parameter, TARGETS[parameter.name]) for parameter in self._parameters()),
            speed=band(self.speed_from, self.speed_to, self.n_speed, RPM),
            channels=channels_of(self.sensors, self.directions),
        )

    def reference(self) -> dict[str, float]:
        """Stiffness and unbalance of Table 7, SI; no damping is published, the one here is assumed."""
        return {
            "kxx": 28e6,
            "kyy": 32e6,
            "cxx": ASSUMED_DAMPING,
            "cyy": ASSUMED_DAMPING,
            "u": 80 * GRAM_MILLIMETRE,
        }

    def _parameters(self) -> list[Parameter]:
        return limited_parameters(FIVE_UNKNOWNS, LIMITS, self.limits)

    def _rotor(self) -> Rotor:
        return rk4_rotor(
            *LAYOUTS[self.layout],
            disk_radius=self.disk_diameter / 2e3,
            disk_thickness=None if self.disk_thickness is None else self.disk_thickness / 1e3,
            material=Material(self.young_modulus * GIGAPASCAL, DENSITY, POISSON_RATIO),
            mesh=self.mesh,
        )


def rk4_rotor(
    span: float,
    overhang: float,
    *,
    disk_radius: float,
    disk_thickness: float | None,
    material: Material,
    mesh: int | None,
) -> Rotor:
    """The rotor without the values of its unknowns: bearings and unbalance have their positions only.

    Lengths in m.
    """
    length, middle = span + overhang, span / 2
    if disk_thickness is None:
        disk_thickness = solid_thickness(disk_radius, material.density)
    return Rotor(
        segments=uniform_shaft(
            length,
            (middle, span),
            round(length / ELEMENT_LENGTH) if mesh is None else mesh,
            radius=SHAFT_RADIUS,
            material=material,
        ),
        disks=(
            weighed_ring(
                middle,
                mass=DISK_MASS,
                outer_radius=disk_radius,
                inner_radius=SHAFT_RADIUS,
                thickness=disk_thickness,
            ),
        ),
        bearings=(Bearing(0.0), Bearing(span)),
        unbalance=(UnbalancePlane(middle),),
    )


def solid_thickness(radius: float, density: float) -> float:
    """Thickness (m) at which a solid ring on the shaft has the disk's mass.

    >>> round(solid_thickness(0.038, 7850.0), 5)
    0.01666
    """
    return DISK_MASS / (density * math.pi * (radius**2 - SHAFT_RADIUS**2))
