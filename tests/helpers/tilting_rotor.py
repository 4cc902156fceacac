"""A rotor that bounces and pitches as a rigid body, in closed form."""

from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.segments import Disk, Material, ShaftSegment

STIFFNESS, DAMPING = 1e5, 40.0  # of each bearing, N/m and N s/m
HALF_SPAN = 0.3  # m


def tilting_rotor():
    """A thick short shaft with a wide disk in the middle on soft bearings at its ends.

    It moves as a rigid body.

    The shaft is 1e5 times stiffer than its bearings, so that flexibility moves frequencies by less than 1e-5.
    """
    light = Material(young_modulus=2e13, density=1.0, poisson_ratio=0.3)
    segment = ShaftSegment(HALF_SPAN, 0.05, light, 2)
    bearings = tuple(Bearing(z, kxx=STIFFNESS, kyy=STIFFNESS, cxx=DAMPING, cyy=DAMPING) for z in (0.0, 2 * HALF_SPAN))
    disk = Disk(HALF_SPAN, mass=20.0, polar_inertia=0.4, diametral_inertia=0.9)
    return Rotor((segment, segment), (disk,), bearings)


def rigid_properties(rotor):
    """Mass, polar and diametral inertia of shaft and disk together."""
    segment, disk = rotor.segments[0], rotor.disks[0]
    mass, squared = segment.material.density * segment.area * rotor.length, segment.outer_radius**2
    return (
        disk.mass + mass,
        disk.polar_inertia + mass * squared / 2,
        disk.diametral_inertia + mass * (3 * squared + rotor.length**2) / 12,
    )
