"""Responses and critical speeds of the three-disk rotor by ROSS.

The same Timoshenko elements have six degrees of freedom at a node instead of our four. Source: Timbó et al., J. Open Source Softw. 5
(2020) 2120, doi 10.21105/joss.02120.
"""

from __future__ import annotations

from itertools import count

import numpy as np
import ross as rs

from benchmarks.harness.task import Task
from benchmarks.tasks import three_disk as rotor

DOF = 6  # of a node
READ = [DOF * rotor.PROBE_NODE, DOF * rotor.PROBE_NODE + 1]


def shaft_and_disks() -> tuple[list, list]:
    steel = rs.Material(name="steel", rho=rotor.DENSITY, E=rotor.YOUNG, G_s=rotor.SHEAR)
    length = rotor.LENGTH / rotor.N_ELEMENT
    shaft = [rs.ShaftElement(L=length, idl=0, odl=rotor.DIAMETER, material=steel) for _ in range(rotor.N_ELEMENT)]
    disks = [
        rs.DiskElement.from_geometry(node, steel, width=thickness, i_d=rotor.DIAMETER, o_d=diameter)
        for node, diameter, thickness in rotor.DISKS
    ]
    return shaft, disks


def machine(elements: tuple[list, list], x: np.ndarray) -> rs.Rotor:
    """The rotor with other bearings: a new one, since ROSS keeps matrices of what it was built with."""
    kxx, kyy, cxx, cyy = (float(value) for value in x[:4])
    bearings = [rs.BearingElement(n=n, kxx=kxx, kyy=kyy, cxx=cxx, cyy=cyy) for n in rotor.BEARING_NODES]
    return rs.Rotor(*elements, bearings)


def response(elements: tuple[list, list], x: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """(n_speed, 2) m by `run_unbalance_response`."""
    found = machine(elements, x).run_unbalance_response(
        node=rotor.UNBALANCED_NODE, unbalance_magnitude=float(x[4]), unbalance_phase=0.0, frequency=speed
    )
    return found.forced_resp[READ].T


def by_transfer_matrix(elements: tuple[list, list], x: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """Response by a loop over its transfer matrices."""
    built = machine(elements, x)
    force = built._unbalance_force(rotor.UNBALANCED_NODE, float(x[4]), 0.0, speed)
    return np.array([(built.transfer_matrix(each) @ force[:, i])[READ] for i, each in enumerate(speed)])


def evaluation(n_speed: int, loop: bool = False) -> Task:
    """One set of unknowns: bearings rebuilt, then the response."""
    elements, speed, points = shaft_and_disks(), rotor.speeds(n_speed), rotor.drawn(rotor.N_COMPARED)
    evaluate = by_transfer_matrix if loop else response
    return Task(
        lambda turn: evaluate(elements, points[0], speed),
        values=lambda _: np.array([evaluate(elements, each, speed) for each in points]),
    )


def set_up(n_speed: int) -> Task:
    speed = rotor.speeds(n_speed)
    return Task(lambda turn: response(shaft_and_disks(), rotor.TRUTH, speed), values=lambda found: found)


def critical_speeds() -> Task:
    """Critical speeds below the highest speed of the band, rad/s, with other bearings at each call."""
    elements, points = shaft_and_disks(), (rotor.TRUTH * (1 + 1e-6 * number) for number in count())

    def found(turn: int) -> np.ndarray:
        speeds = np.asarray(machine(elements, next(points)).run_critical_speed().wd())
        return np.sort(speeds[speeds < rotor.speeds(2)[-1]])

    return Task(found, values=lambda speeds: speeds)
