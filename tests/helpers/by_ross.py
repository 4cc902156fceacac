"""Motion, forces of a bent shaft and files with noise for run-ups by ROSS.

Parts of the scripts that make these. Like the scripts, it contains nothing of this project. Real quantities are Re(q e^{iΩt}), m 0-peak.
"""

import csv

import numpy as np

NOISE = 0.05  # of each reading
ORIGIN = 0.6  # rad, of all phases
FORWARD = np.array([1, -1j])  # a vector that turns with the shaft, in x and y
DOF = 6  # of ROSS at a node: x, y, z, and rotations about these


def motion(rotor, force, nodes, speed):
    """Of nodes in x and y (n_speed, n_node, 2), m, under nodal forces (n_dof, n_speed), N."""
    dof = np.array([[DOF * node + axis for axis in (0, 1)] for node in nodes])
    return np.array([(rotor.transfer_matrix(each) @ force[:, i])[dof] for i, each in enumerate(speed)])


def bending_forces(stiffness, shape, slope, size, n_dof, n_speed):
    """Nodal forces (n_dof, n_speed), N, of a bent shaft: its own stiffness times the bow.

    The stiffness is without bearings. The bow is `size` (complex), m, times a shape (n_node,) that has a slope, 1/m.
    """
    bent = np.zeros((len(shape), DOF), dtype=complex)
    bent[:, :2] = shape[:, None] * FORWARD
    bent[:, 3:5] = slope[:, None] * np.array([1j, 1])  # rotation about x is −dy/dz
    force = np.zeros(n_dof, dtype=complex)
    force[: len(stiffness)] = stiffness @ (size * bent.ravel())
    return np.tile(force[:, None], (1, n_speed))


def write(path, speed, probes, directions, readings, floor, rng):
    """A CSV file of readings (n_speed, n_probe, n_direction), m, with noise and a floor, m."""
    noise = rng.standard_normal((*readings.shape, 2)) @ [1, 1j] / np.sqrt(2)
    seen = (readings + np.sqrt((NOISE * np.abs(readings)) ** 2 + floor**2) * noise) * np.exp(1j * ORIGIN)
    with path.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["speed_rpm", "position_m", "direction", "amplitude_um_0pk", "phase_lead_deg"])
        for each, at_speed in zip(speed, seen):
            for probe, pair in zip(probes, at_speed):
                for direction, value in zip(directions, pair):
                    rest = [1e6 * abs(value), np.degrees(np.angle(value))]
                    table.writerow([30 / np.pi * each, probe, direction, *rest])
