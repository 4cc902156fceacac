"""Ranges that drawn machines of all families and kinds share.

They are sizes of a turbine and of a rig, steel, and the scale of an unknown.
"""

from __future__ import annotations

from dataclasses import dataclass

from ksmea.units import DEGREE, GIGAPASCAL
from problems.drawn_numbers import Range

YOUNG_MODULUS = 190 * GIGAPASCAL, 215 * GIGAPASCAL  # of steels at room temperature; the model is told the drawn value
DENSITY, POISSON_RATIO = 7850.0, 0.3  # kg/m³; of steel
ANISOTROPY = 0.5, 2.0  # stiffness and damping in y in parts of those in x; Table 1 has 1.4
FULL_TURN = -180 * DEGREE, 180 * DEGREE
QUANTITY_BY_LETTER = {
    "k": "stiffness",
    "c": "damping",
    "u": "unbalance",
    "p": "angle",
}  # by the first letter of an unknown


@dataclass(frozen=True)
class Machine:
    """Ranges of a kind of machine, SI.

    Values of the published one, about 0.6 to 1.6 times as small and as large; what nobody published is named as such.
    """

    shaft_radius: Range
    span: Range  # between the bearings
    disk_radius: Range
    disk_thickness: Range
    stiffness: Range  # of a bearing in x
    damping: Range
    unbalance: Range
    fastest: float  # rad/s, up to which critical speeds are looked for


# Table 1: radius 0.05, span 1.3, disks 0.12 and 0.20 by 0.05 and 0.06 m, k 50 and 70 MN/m, c 500 and 700 N s/m, 200 g mm.
TURBINE = Machine(
    shaft_radius=(0.04, 0.065),
    span=(1.0, 1.8),
    disk_radius=(0.11, 0.22),
    disk_thickness=(0.04, 0.075),
    stiffness=(2e7, 1.2e8),
    damping=(300.0, 5000.0),  # the published one damps its criticals by about 1 %; machines by up to ten times as much
    unbalance=(1e-4, 6e-4),
    fastest=4000.0,
)
# RK-4: radius 0.005, span 0.32 to 0.56, disk 0.038 by 0.017 to 0.025 m; k 0.07 to 0.8 MN/m and c 90 to 500 N s/m are what the
# published run-up of the two-disk rig asks for; the 28 MN/m of Table 7 cannot be seen beside so slender a shaft.
RIG = Machine(
    shaft_radius=(0.004, 0.0065),
    span=(0.28, 0.5),
    disk_radius=(0.03, 0.045),
    disk_thickness=(0.012, 0.03),
    stiffness=(4e4, 4e5),
    damping=(20.0, 300.0),
    unbalance=(2e-5, 3e-4),  # Table 7 has 80 g mm
    fastest=2500.0,
)
