"""Run-ups of the three-disk rotor by ROSS, another finite-element program.

Each has one thing that a plain model lacks.

    python run_ups_by_ross.py FOLDER

writes FOLDER/NAME.csv for each cause. Nothing here is of this project: geometry and coefficients are those of Table 1 of Han,
Guo & Gao (2013), doi 10.1016/j.jsv.2012.12.025, elements, matrices and unbalance forces those of ROSS (Timbó et al., J. Open
Source Softw. 5 (2020) 2120, doi 10.21105/joss.02120). Real quantities are Re(q e^{iΩt}), m 0-peak, in both.
"""

import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import ross as rs

from by_ross import FORWARD, bending_forces, motion, write

SPEED = np.linspace(200.0, 1500.0, 53)  # rad/s
# every 50 mm, and the edges of the second disk's hub
NODES = np.sort(np.append(np.linspace(0.0, 1.3, 27), [0.475, 0.525]))  # m
PROBES = (0.1, 0.2, 0.5)  # m, each in x and y
DISKS = ((0.2, 0.24, 0.05), (0.5, 0.4, 0.05), (1.0, 0.4, 0.06))  # position, diameter, thickness, m
BEARING = {"kxx": 50e6, "kyy": 70e6, "cxx": 500.0, "cyy": 700.0}  # N/m, N s/m
YOUNG, SHEAR, DENSITY, DIAMETER = 200e9, 200e9 / 2.6, 7800.0, 0.1
UNBALANCE = 2e-4  # kg m, on the second disk
FLOOR = 1e-7  # m


def node(position):
    return int(np.argmin(np.abs(NODES - position)))


def machine(bearings=(BEARING, BEARING), stiffer=1.0, heavier=1.0, hub=None, further=(), pedestal=None, **of_elements):
    """Rotor with other bearings, Young's modulus, mass, hub, further disks or pedestals.

    The hub of another diameter is on the second disk; `of_elements` are those of ROSS.
    """
    plain = rs.Material(name="plain", rho=heavier * DENSITY, E=stiffer * YOUNG, G_s=stiffer * SHEAR)
    shaft = []
    for left, right in pairwise(NODES):
        diameter, material = DIAMETER, plain
        if hub and 0.475 <= left < 0.525:
            diameter, light = hub, (DIAMETER / hub) ** 2  # no heavier
            material = rs.Material(name="hub", rho=light * DENSITY, E=YOUNG, G_s=SHEAR)
        shaft.append(rs.ShaftElement(L=right - left, idl=0, odl=diameter, material=material, **of_elements))
    disks = [
        rs.DiskElement.from_geometry(node(position), plain, width=thickness, i_d=DIAMETER, o_d=diameter)
        for position, diameter, thickness in DISKS
    ]
    ends = (0, len(NODES) - 1)
    if pedestal is None:
        supports, masses = [rs.BearingElement(n=end, **each) for end, each in zip(ends, bearings)], []
    else:
        below = [len(NODES), len(NODES) + 1]
        supports = [rs.BearingElement(n=end, n_link=base, **BEARING) for end, base in zip(ends, below)]
        supports += [rs.BearingElement(n=base, **pedestal["springs"]) for base in below]
        masses = [rs.PointMass(n=base, m=pedestal["mass"]) for base in below]
    return rs.Rotor(shaft, [*disks, *further], supports, masses)


def over_speed(**changes):
    """A bearing whose named coefficients are given at the speeds."""
    return {"frequency": SPEED, **{name: value * np.ones(len(SPEED)) for name, value in {**BEARING, **changes}.items()}}


def response(rotor, forces=0.0):
    """Readings of the probes (n_speed, n_probe, 2), m, of the unbalance and further nodal forces.

    The forces are (n_dof, n_speed), N.
    """
    force = forces + rotor._unbalance_force(node(0.5), UNBALANCE, 0.0, SPEED)
    return motion(rotor, force, [node(probe) for probe in PROBES], SPEED)


def bow(size):
    """Readings of a rotor that is bent as half a sine, `size` (complex) m in its middle."""
    free, argument = machine(bearings=(dict.fromkeys(BEARING, 0.0),) * 2), np.pi * NODES / NODES[-1]
    slope = np.pi / NODES[-1] * np.cos(argument)
    return response(machine(), bending_forces(free.K(0), np.sin(argument), slope, size, free.ndof, len(SPEED)))


def readings():
    """Readings of each machine, (n_speed, n_probe, 2) m, by the name of the missing cause.

    A plain model of the machine lacks it.
    """
    plain = response(machine())
    rising = SPEED / SPEED[-1]
    runout, gain, turned = plain.copy(), plain.copy(), plain.copy()
    runout[:, 1] += 1.5e-6 * np.exp(0.8j) * FORWARD
    gain[:, 2, 1] *= 1.15
    cos, sin = np.cos(0.2), np.sin(0.2)
    turned[:, 1] = plain[:, 1] @ np.array([[cos, -sin], [sin, cos]])
    balanced = machine()
    lossy = {f"k{axis}{axis}": value * np.ones(len(SPEED)) for axis, value in (("x", 1.5e8), ("y", 2e8))}
    lossy |= {f"c{axis}{axis}": 0.02 * lossy[f"k{axis}{axis}"] / SPEED for axis in "xy"}  # loss factor 0.02
    return {
        "none": plain,
        "runout": runout,
        "channel_gain": gain,
        "probe_rotation": turned,
        "timing_delay": plain * np.exp(-2e-4j * SPEED)[:, None, None],
        "residual_bow": bow(5e-6 * np.exp(0.5j)),
        "unbalance": response(balanced, balanced._unbalance_force(node(1.0), 8e-5, 0.9, SPEED)),
        "cross_coupling_symmetric": response(machine(({**BEARING, "kxy": 2e6, "kyx": 2e6},) * 2)),
        "cross_coupling_antisymmetric": response(machine(({**BEARING, "kxy": 2e5, "kyx": -2e5},) * 2)),
        "speed_dependent_stiffness": response(
            machine((over_speed(kxx=5e7 * (1 + 0.2 * rising), kyy=7e7 * (1 + 0.2 * rising)),) * 2)
        ),
        "speed_dependent_damping": response(
            machine((over_speed(cxx=500 * (1 + 3 * rising), cyy=700 * (1 + 3 * rising)),) * 2)
        ),
        "flexible_pedestal": response(machine(pedestal={"springs": {"frequency": SPEED, **lossy}, "mass": 30.0})),
        "unequal_bearings": response(
            machine(({**BEARING, "kxx": 6e7, "kyy": 6e7}, {**BEARING, "kxx": 4e7, "kyy": 8e7}))
        ),
        "youngs_modulus": response(machine(stiffer=1.03)),
        "mass": response(machine(heavier=1.02)),
        "added_mass": response(machine(further=[rs.DiskElement(n=node(0.2), m=4.0, Id=0.0, Ip=0.0)])),
        "axial_force": response(machine(axial_force=3e5)),
        "shear_theory": response(machine(shear_effects=False)),
        "hub_stiffening": response(machine(hub=0.13)),
        "external_damping": response(machine(alpha=5.0)),  # per second, times the shaft's mass
    }


if __name__ == "__main__":
    for seed, (name, values) in enumerate(readings().items()):
        path = Path(sys.argv[1]) / f"{name}.csv"
        write(path, SPEED, PROBES, "xy", values, FLOOR, np.random.default_rng(seed))
