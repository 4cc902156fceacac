"""Run-ups of three machines of other kinds than the paper's rotor, by another program, ROSS.

A pump with overhung impellers, a turbine of five disks through two critical speeds, and a small rig with a thin shaft and a disk beyond
each bearing. Each run-up has one thing that its rotor file lacks.

    python machines_by_ross.py FOLDER

writes FOLDER/MACHINE.yaml and FOLDER/MACHINE_CAUSE.csv for each cause. Nothing here is of this project: elements, matrices and
unbalance forces are those of ROSS (Timbó et al., J. Open Source Softw. 5 (2020) 2120, doi 10.21105/joss.02120). Real quantities are
Re(q e^{iΩt}), m 0-peak.
"""

import sys
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import ross as rs

from by_ross import bending_forces, motion, write

YOUNG, POISSON, DENSITY = 206e9, 0.29, 7850.0
FLOOR = 5e-8  # m
N_ELEMENT = 36  # at least


@dataclass(frozen=True)
class Machine:
    """A machine in SI units."""

    segments: tuple[tuple[float, float, int], ...]  # length, diameter, elements of the rotor file
    disks: tuple[tuple[float, float, float, float], ...]  # position, mass, polar and diametral inertia
    bearings: tuple[float, float]
    coefficients: tuple[dict[str, float], dict[str, float]]
    unbalance: tuple[float, float]  # position, magnitude
    probes: tuple[float, ...]
    angles: tuple[float, float]  # of the probes at each position, degrees from x to y
    speed: np.ndarray
    hidden: dict[str, float]  # sizes and places of what is hidden, as far as they differ between machines

    @property
    def length(self):
        return sum(length for length, _, _ in self.segments)


def same(kxx, kyy, cxx, cyy):
    return ({"kxx": kxx, "kyy": kyy, "cxx": cxx, "cyy": cyy},) * 2


MACHINES = {
    "pump": Machine(
        segments=((0.15, 0.050, 3), (0.45, 0.062, 9), (0.30, 0.054, 6)),
        disks=((0.0, 4.0, 0.012, 0.008), (0.75, 8.0, 0.055, 0.030), (0.90, 10.0, 0.080, 0.045)),
        bearings=(0.15, 0.60),
        coefficients=same(4.0e7, 5.5e7, 6e3, 9e3),
        unbalance=(0.90, 8e-5),
        probes=(0.20, 0.55, 0.85),
        angles=(0.0, 90.0),
        speed=np.linspace(60.0, 690.0, 49),
        hidden={
            "bow": 10e-6,
            "moved": 0.04,
            "at": 0.75,
            "mass": 0.8,
            "further": 5e-5,
            "cross": 3e6,
            "below": 6e7,
            "carried": 100.0,
        },
    ),
    "turbine": Machine(
        segments=((0.10, 0.080, 2), (0.30, 0.100, 5), (0.80, 0.110, 12), (0.30, 0.100, 5), (0.10, 0.080, 2)),
        disks=tuple((position, 32.0, 0.55, 0.28) for position in (0.40, 0.60, 0.80, 1.00, 1.20)),
        bearings=(0.10, 1.50),
        coefficients=same(6.0e7, 9.0e7, 2.5e4, 3.5e4),
        unbalance=(0.60, 6e-4),
        probes=(0.20, 0.70, 1.40),
        angles=(45.0, 135.0),
        speed=np.linspace(90.0, 900.0, 61),
        hidden={
            "bow": 12e-6,
            "moved": 0.06,
            "at": 0.80,
            "mass": 4.0,
            "further": 4e-4,
            "cross": 4e6,
            "below": 1.2e8,
            "carried": 150.0,
        },
    ),
    "rig": Machine(
        segments=((0.12, 0.012, 3), (0.36, 0.014, 10), (0.12, 0.012, 3)),
        disks=((0.0, 0.5, 5e-4, 2.6e-4), (0.30, 0.9, 1.2e-3, 6.5e-4), (0.60, 0.5, 5e-4, 2.6e-4)),
        bearings=(0.12, 0.48),
        coefficients=same(4.0e5, 7.0e5, 90.0, 130.0),
        unbalance=(0.30, 1.5e-5),
        probes=(0.06, 0.24, 0.54),
        angles=(0.0, 90.0),
        speed=np.linspace(60.0, 560.0, 53),
        hidden={
            "bow": 20e-6,
            "moved": 0.02,
            "at": 0.30,
            "mass": 0.06,
            "further": 1e-5,
            "cross": 3e4,
            "below": 7e5,
            "carried": 2.5,
        },
    ),
}


def nodes(machine):
    """Of all that anything needs, and further ones between."""
    moved = machine.probes[1] + machine.hidden["moved"]
    ends = np.cumsum([0.0, *(length for length, _, _ in machine.segments)])
    places = {*np.round(ends, 9), *(disk[0] for disk in machine.disks), *machine.bearings, *machine.probes, moved}
    places |= {machine.unbalance[0], machine.hidden["at"]}
    places = np.array(sorted(places))
    widest = machine.length / N_ELEMENT
    filled = [np.linspace(a, b, max(1, int(np.ceil((b - a) / widest))), endpoint=False) for a, b in pairwise(places)]
    return np.concatenate([*filled, places[-1:]])


def rotor_of(machine, bearings=None, further=(), pedestal=None):
    """The machine with other bearings, further disks, or pedestals (stiffness N/m, mass kg)."""
    places = nodes(machine)
    steel = rs.Material(name="steel", rho=DENSITY, E=YOUNG, Poisson=POISSON)
    ends = np.cumsum([length for length, _, _ in machine.segments])
    shaft = []
    for left, right in pairwise(places):
        diameter = machine.segments[int(np.searchsorted(ends, (left + right) / 2))][1]
        shaft.append(rs.ShaftElement(L=right - left, idl=0, odl=diameter, material=steel))
    disks = [
        rs.DiskElement(n=at(places, position), m=mass, Ip=polar, Id=other)
        for position, mass, polar, other in machine.disks
    ]
    disks += [rs.DiskElement(n=at(places, position), m=mass, Ip=0.0, Id=0.0) for position, mass in further]
    held = [at(places, position) for position in machine.bearings]
    each = bearings or machine.coefficients
    if pedestal is None:
        return rs.Rotor(shaft, disks, [rs.BearingElement(n=n, **own) for n, own in zip(held, each)])
    stiffness, mass = pedestal
    below = [len(places), len(places) + 1]
    supports = [rs.BearingElement(n=n, n_link=base, **own) for n, base, own in zip(held, below, each)]
    supports += [rs.BearingElement(n=base, kxx=stiffness, cxx=1e-5 * stiffness) for base in below]
    return rs.Rotor(shaft, disks, supports, [rs.PointMass(n=base, m=mass) for base in below])


def at(places, position):
    return int(np.argmin(np.abs(places - position)))


def response(machine, rotor, forces=0.0, probes=None):
    """Readings (n_speed, n_probe, 2), m, of the unbalance and of further nodal forces (n_dof, n_speed), N."""
    places = nodes(machine)
    position, magnitude = machine.unbalance
    force = forces + rotor._unbalance_force(at(places, position), magnitude, 0.0, machine.speed)
    seen = motion(rotor, force, [at(places, probe) for probe in probes or machine.probes], machine.speed)
    cosines = np.array([[np.cos(np.radians(angle)), np.sin(np.radians(angle))] for angle in machine.angles])
    return seen @ cosines.T


def bent(machine, rotor, size):
    """Nodal forces (n_dof, n_speed) of a bow, a half sine between the bearings and straight outside.

    They are its own stiffness times that.
    """
    places = nodes(machine)
    left, right = machine.bearings
    part = np.clip((places - left) / (right - left), 0.0, 1.0)
    slope = np.pi / (right - left) * np.cos(np.pi * part)
    shape = np.sin(np.pi * part) + slope * (places - left - part * (right - left))
    nothing = dict.fromkeys(machine.coefficients[0], 0.0)
    free = rotor_of(machine, (nothing, nothing)).K(0)
    return bending_forces(free, shape, slope, size, rotor.ndof, len(machine.speed))


def readings(machine):
    """Readings of the machine by the name of what its rotor file lacks."""
    size, plain = machine.hidden, rotor_of(machine)
    seen = response(machine, plain)
    rising = machine.speed / machine.speed[-1]
    runout, gain = seen.copy(), seen.copy()
    turning = np.exp(-1j * np.radians(machine.angles))
    runout[:, 1] += size["bow"] / 3 * np.exp(0.8j) * turning
    gain[:, 2, 1] *= 1.15
    first, second = machine.coefficients
    growing = [
        {
            "frequency": machine.speed,
            **{name: value * (1 + 0.3 * rising * name.startswith("k")) for name, value in own.items()},
        }
        for own in machine.coefficients
    ]
    crossed = [{**own, "kxy": size["cross"], "kyx": -size["cross"]} for own in machine.coefficients]
    softer = (
        {name: value * 1.25 for name, value in first.items()},
        {name: value * 0.8 for name, value in second.items()},
    )
    moved = [*machine.probes[:1], machine.probes[1] + size["moved"], *machine.probes[2:]]
    other_disk = machine.disks[-1 if machine.unbalance[0] != machine.disks[-1][0] else 1][0]
    further = plain._unbalance_force(at(nodes(machine), other_disk), size["further"], 0.9, machine.speed)
    return {
        "none": seen,
        "runout": runout,
        "channel_gain": gain,
        "probe_position": response(machine, plain, probes=moved),
        "residual_bow": response(machine, plain, bent(machine, plain, size["bow"] * np.exp(0.5j))),
        "unbalance": response(machine, plain, further),
        "cross_coupling_antisymmetric": response(machine, rotor_of(machine, crossed)),
        "speed_dependent_stiffness": response(machine, rotor_of(machine, growing)),
        "unequal_bearings": response(machine, rotor_of(machine, softer)),
        "flexible_pedestal": response(machine, rotor_of(machine, pedestal=(size["below"], size["carried"]))),
        "added_mass": response(machine, rotor_of(machine, further=[(size["at"], size["mass"])])),
    }


def rotor_file(machine):
    """The machine as its rotor file has it, with one set of unknowns for both bearings."""
    lines = [
        "units: {length: m, modulus: Pa, density: kg/m3, mass: kg, inertia: kg m2, stiffness: N/m, damping: N s/m, unbalance: kg m,",
        "        angle: deg, speed: rad/s}",
        f"materials: {{steel: {{young_modulus: {YOUNG}, density: {DENSITY}, poisson_ratio: {POISSON}}}}}",
        "shaft:",
        *(
            f"  - {{length: {length}, outer_diameter: {diameter}, material: steel, elements: {n}}}"
            for length, diameter, n in machine.segments
        ),
        "disks:",
        *(
            f"  - {{position: {position}, mass: {mass}, polar_inertia: {polar}, diametral_inertia: {other}}}"
            for position, mass, polar, other in machine.disks
        ),
        f"bearings: [{', '.join(f'{{position: {position}}}' for position in machine.bearings)}]",
        f"unbalance: [{{position: {machine.unbalance[0]}, phase: 0}}]",
        f"speeds: {{from: {machine.speed[0]}, to: {machine.speed[-1]}, number: {len(machine.speed)}}}",
        "probes:",
        *(
            f"  - {{position: {probe}, direction: {name_of(angle)}}}"
            for probe in machine.probes
            for angle in machine.angles
        ),
        "unknowns:",
    ]
    for name, value in machine.coefficients[0].items():
        sets = f"[bearing 1 {name}, bearing 2 {name}]"
        lines.append(
            f"  - {{name: {name}, lower: {value / 8:.6g}, upper: {value * 8:.6g}, reference: {value:.6g}, sets: {sets}}}"
        )
    magnitude = machine.unbalance[1]
    limits = f"lower: {magnitude / 20:.6g}, upper: {magnitude * 5:.6g}, reference: {magnitude:.6g}"
    return "\n".join([*lines, f"  - {{name: u, {limits}, sets: [unbalance 1 magnitude]}}", ""])


def name_of(angle):
    return {0.0: "x", 90.0: "y"}.get(angle, f"{angle:g}")


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    for number, (name, machine) in enumerate(MACHINES.items()):
        (folder / f"{name}.yaml").write_text(rotor_file(machine))
        for seed, (cause, values) in enumerate(readings(machine).items()):
            path, names = folder / f"{name}_{cause}.csv", [name_of(angle) for angle in machine.angles]
            write(path, machine.speed, machine.probes, names, values, FLOOR, np.random.default_rng([number, seed]))
