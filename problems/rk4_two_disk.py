"""A Bently Nevada RK-4 rig with two disks whose run-up is public.

M-Nouioua/rk4-rotor-unbalance-estimation (GitHub, commit f3fd3be0; raw data on Zenodo, CC BY 4.0).

Its owners give the shaft's diameter, the disks' mass and size, and two descriptions of the axial layout: a beam
model of 28 elements of 20 mm with bearings at 40 and 520 mm, disks at 160 and 400 mm and probes at 120 and 440 mm,
"typical, to be calibrated"; and "560 mm between bearing centres". They read a first critical speed of 1648 rpm, a
damping ratio of 0.04 and a smaller resonance near 1750 rpm; the published run-up of one probe has its largest
amplitude at 1665 rpm.

What those claims mean for the bearings, by this model (steel, E = 210 GPa), in rpm:

    layout               first critical pair   lower of it for k in MN/m of
                         on rigid supports     0.02   0.05   0.1    0.2    0.5    1
    beam_model           2037 and 2088         1149   1503   1715   1857   1960   1998
    bearing_centres_560  1759 and 1806         1091   1378   1537   1638   1708   1733

The second layout keeps the model's distances from each bearing to its disk and probe. Were the disks to stay 240 mm
apart instead, the first critical speed on rigid supports would be 1487 rpm, and no bearing would give the measured
one. So the supports are tens to hundreds of times softer than the 28 MN/m of the reference paper's rig, and the
default limits of k are 0.02 and 1 MN/m. Critical speeds of 1648 and 1750 rpm need supports of different stiffness in x and
y: on equal ones gyroscopic moments part the pair by some 50 rpm at most. 1648 and 1750 rpm and a damping ratio of 0.04 of
the lower mode determine kxx, kyy and c = cxx = cyy: they are the assumed reference, for each layout.

A probe in x sees kyy and cyy through gyroscopic moments alone; amplitudes see the two unbalances' difference of phase
and not the phases.
"""

from __future__ import annotations

from dataclasses import dataclass

from ksmea.plugins.source import ProblemSettings
from ksmea.problem.parameters import Parameter
from ksmea.settings.settings import setting
from ksmea.units import DEGREE, GRAM_MILLIMETRE, KILONEWTON_SECOND_PER_METRE, MEGANEWTON_PER_METRE, RPM
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Rotor, UnbalancePlane
from problems.rotor.finite_elements.mesh import uniform_shaft, weighed_ring
from problems.rotor.finite_elements.segments import Material
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.unknowns import BearingTarget, Target, UnbalanceTarget, Unknown
from problems.rotor_settings import band, channels_of, check_band, check_probes, check_size, limited_parameters

OWNERS = "M-Nouioua/rk4-rotor-unbalance-estimation"
GIGAPASCAL = 1e9  # Pa

SHAFT_LENGTH = 0.56  # m
SHAFT_RADIUS = 0.005  # m
DISK_MASS = 0.8  # kg; a solid steel ring of this size has 0.875 kg, the holes for balance weights take the rest
DISK_RADIUS = 0.038  # m
DISK_THICKNESS = 0.025  # m
POISSON_RATIO = 0.3  # of steel; it enters through shear, which a slender shaft has next to none of


@dataclass(frozen=True)
class Layout:
    """Positions on the shaft of 560 mm, m from its left end, and coefficients (N/m, N s/m).

    With these this model has what the owners read: criticals at 1648 and 1750 rpm, damping ratio 0.04 of the lower
    mode.
    """

    bearings: tuple[float, float]
    disks: tuple[float, float]
    probes: tuple[float, float]
    kxx: float
    kyy: float
    damping: float


LAYOUTS = {
    "beam_model": Layout((0.04, 0.52), (0.16, 0.40), (0.12, 0.44), kxx=74.4e3, kyy=108e3, damping=94.5),
    "bearing_centres_560": Layout((0.0, 0.56), (0.12, 0.44), (0.08, 0.48), kxx=153e3, kyy=799e3, damping=509.0),
}

# Residual unbalance is not published; this one has its amplitude in x peak at about 20 µm in layout beam_model, as
# the run-up does.
ASSUMED_UNBALANCE = {
    "u1": 3 * GRAM_MILLIMETRE,
    "phase1": 30 * DEGREE,
    "u2": 1.5 * GRAM_MILLIMETRE,
    "phase2": 100 * DEGREE,
}

UNITS = {  # of each unknown: the unit people read and its size in SI
    "kxx": ("MN/m", MEGANEWTON_PER_METRE),
    "kyy": ("MN/m", MEGANEWTON_PER_METRE),
    "cxx": ("kN s/m", KILONEWTON_SECOND_PER_METRE),
    "cyy": ("kN s/m", KILONEWTON_SECOND_PER_METRE),
    "u1": ("g mm", GRAM_MILLIMETRE),
    "phase1": ("deg", DEGREE),
    "u2": ("g mm", GRAM_MILLIMETRE),
    "phase2": ("deg", DEGREE),
}
LIMITS = {
    "kxx": [0.02, 1.0],
    "kyy": [0.02, 1.0],
    "cxx": [0.01, 1.0],
    "cyy": [0.01, 1.0],
    "u1": [0.3, 30.0],
    "phase1": [-270.0, 270.0],
    "u2": [0.3, 30.0],
    "phase2": [-270.0, 270.0],
}
TARGETS: dict[str, tuple[Target, ...]] = {  # what each unknown sets; both supports alike
    **{name: (BearingTarget(0, name), BearingTarget(1, name)) for name in ("kxx", "kyy", "cxx", "cyy")},
    "u1": (UnbalanceTarget(0),),
    "phase1": (UnbalanceTarget(0, "phase"),),
    "u2": (UnbalanceTarget(1),),
    "phase2": (UnbalanceTarget(1, "phase"),),
}


@dataclass(frozen=True)
class RK4TwoDisk(ProblemSettings):
    """The two-disk RK-4 rig on two equal soft supports.

    Four support coefficients and each disk's unbalance, as magnitude and phase, are unknown.
    """

    layout: str = setting(
        "beam_model",
        "which of the owners' two descriptions holds: beam_model has the bearings at 40 and 520 mm of the shaft,"
        " bearing_centres_560 at its ends, with the same distances from bearing to disk and probe",
        source=OWNERS,
        choices=tuple(LAYOUTS),
    )
    young_modulus: float = setting(
        210.0,
        "Young's modulus; not published, 210 GPa is what the reference paper means for its RK-4 shaft",
        unit="GPa",
        above=0,
    )
    density: float = setting(
        7850.0,
        "density of the shaft; not published, taken from the reference paper's RK-4 shaft",
        unit="kg/m³",
        above=0,
    )
    mesh: int = setting(
        28,
        "number of shaft elements, shared by length between bearings, disks and ends; 28 have 20 mm each",
        source=OWNERS,
        at_least=1,
    )
    speed_from: float = setting(1040.0, "first speed; the published run-up starts at 1037", unit="rpm", above=0)
    speed_to: float = setting(2400.0, "last speed; the published run-up ends at 2402", unit="rpm", above=0)
    n_speed: int = setting(69, "number of equally spaced speeds; 69 step by 20", at_least=1)
    sensors: list[float] | None = setting(
        None,
        "positions of the probes, from the shaft's left end; null: plane 1, the probe of the published run-up, at 0.12"
        " (beam_model) or 0.08 (bearing_centres_560). Plane 2 is at 0.44 or 0.48",
        unit="m",
        source=OWNERS,
        at_least=0,
        at_most=SHAFT_LENGTH,
    )
    directions: list[str] = setting(
        ["x"], "directions each probe measures, x or y; the published run-up has x only", source=OWNERS
    )
    limits: dict[str, list[float]] = setting(
        LIMITS,
        "lower and upper limit of each unknown; any that is not named keeps its default. Limits of k put the first"
        " critical speed anywhere from 1150 to 2000 rpm in layout beam_model; limits of c hold damping ratios of 0.004"
        " to 0.1 there; limits of u are about a tenth and ten times what an amplitude of 20 µm needs",
        unit="MN/m, kN s/m, g mm, deg",
    )

    def check(self) -> None:
        check_size(self.mesh, self.n_speed)
        check_band(self.speed_from, self.speed_to, self.n_speed)
        check_probes(self._sensors(), self.directions)
        self._parameters()
        self._rotor()

    def build(self) -> RotorProblem:
        """The problem; its rotor carries no values of the unknowns."""
        return RotorProblem(
            rotor=self._rotor(),
            unknowns=tuple(Unknown(parameter, TARGETS[parameter.name]) for parameter in self._parameters()),
            speed=band(self.speed_from, self.speed_to, self.n_speed, RPM),
            channels=channels_of(self._sensors(), self.directions),
        )

    def reference(self) -> dict[str, float]:
        """Assumed values, SI: no coefficient or unbalance of this rig is published."""
        layout = LAYOUTS[self.layout]
        bearing = {"kxx": layout.kxx, "kyy": layout.kyy, "cxx": layout.damping, "cyy": layout.damping}
        return bearing | ASSUMED_UNBALANCE

    def _sensors(self) -> list[float]:
        return [LAYOUTS[self.layout].probes[0]] if self.sensors is None else self.sensors

    def _parameters(self) -> list[Parameter]:
        return limited_parameters(UNITS, LIMITS, self.limits)

    def _rotor(self) -> Rotor:
        material = Material(self.young_modulus * GIGAPASCAL, self.density, POISSON_RATIO)
        return two_disk_rotor(LAYOUTS[self.layout], material, self.mesh)


def two_disk_rotor(layout: Layout, material: Material, mesh: int) -> Rotor:
    """The rotor without the values of its unknowns: supports and unbalance have their positions only."""
    return Rotor(
        segments=uniform_shaft(
            SHAFT_LENGTH, (*layout.bearings, *layout.disks), mesh, radius=SHAFT_RADIUS, material=material
        ),
        disks=tuple(
            weighed_ring(
                position,
                mass=DISK_MASS,
                outer_radius=DISK_RADIUS,
                inner_radius=SHAFT_RADIUS,
                thickness=DISK_THICKNESS,
            )
            for position in layout.disks
        ),
        bearings=tuple(Bearing(position) for position in layout.bearings),
        unbalance=tuple(UnbalancePlane(position) for position in layout.disks),
    )
