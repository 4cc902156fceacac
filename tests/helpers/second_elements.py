"""A second way to the unbalance response of a rotor.

Linear elements with one point for shear, many to each element of the rotor's mesh.

Deflections x, y and slopes a, b of the sections in the x–z and y–z planes are straight over each step, so that neither shape functions
nor matrices are those of `problems.rotor`. Rings of a section share deflection and slope everywhere; housings are nodes of their own.
All is summed at one speed in the frequency domain, and errors fall with the square of the step.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse
import scipy.sparse.linalg
from scipy.interpolate import PchipInterpolator

ENTRIES = ("xx", "xy", "yx", "yy")


def response(rotor, speed, channels, n_step):
    """Response (n_speed, n_channel) m at speeds (n_speed,) rad/s.

    There are `n_step` steps to each element of the rotor's own mesh.
    """
    return np.array([_Steps(rotor, n_step, omega).read(channels) for omega in speed])


class _Steps:
    """The system at one speed.

    A node has (x, y, a, b); each step lies between two nodes, a coupling is one step.
    """

    def __init__(self, rotor, n_step, omega):
        self.rotor, self.omega = rotor, omega
        self.places, self.entries = [0.0], []
        for segment in rotor.segments:
            self._lay(segment, n_step)
        self.n_node = len(self.places)
        for disk in (*rotor.disks, *rotor.masses):
            self._carry(self._node(disk.position), disk.mass, disk.polar_inertia, disk.diametral_inertia)
        self.housings = {}
        for number, bearing in enumerate((*rotor.bearings, *rotor.seals)):
            self._hold(number, bearing)

    def _node(self, position):
        node = int(np.argmin(np.abs(np.array(self.places) - position)))
        assert abs(self.places[node] - position) < 1e-9, f"no step ends at {position} m"
        return node

    def _add(self, dofs, block):
        rows, columns = np.meshgrid(dofs, dofs, indexing="ij")
        self.entries.append((rows.ravel(), columns.ravel(), np.asarray(block, dtype=complex).ravel()))

    def _lay(self, segment, n_step):
        start, first = self.places[-1], len(self.places) - 1
        if not hasattr(segment, "material"):
            self.places.append(start + segment.length)
            self._join(first, segment)
            return
        n = segment.n_element * n_step
        for step in range(n):
            self.places.append(start + segment.length * (step + 1) / n)
            self._bend(first + step, segment, segment.length / n, (step + 0.5) / n)

    def _bend(self, node, segment, h, middle):
        """One step of a shaft, with the section at its middle."""
        bending = shear = line = turn = 0.0
        for ring in (segment, *segment.layers):
            outer, inner = (_between(ring, name, middle) for name in ("outer_radius", "inner_radius"))
            carries = getattr(ring, "carries", "both")
            if carries != "stiffness":
                line += ring.material.density * np.pi * (outer**2 - inner**2)
                turn += ring.material.density * np.pi / 4 * (outer**4 - inner**4)
            if carries != "mass":
                stiff = getattr(ring, "stiffness_outer_radius", None) or outer
                modulus, nu, m2 = ring.material.young_modulus, ring.material.poisson_ratio, (inner / stiff) ** 2
                cowper = 6 * (1 + nu) * (1 + m2) ** 2 / ((7 + 6 * nu) * (1 + m2) ** 2 + (20 + 12 * nu) * m2)
                kappa = getattr(ring, "shear_coefficient", None) or cowper
                bending += modulus * np.pi / 4 * (stiff**4 - inner**4)
                shear += kappa * modulus / (2 + 2 * nu) * np.pi * (stiff**2 - inner**2)
        spring, tension, inertia = np.zeros((8, 8)), np.zeros((8, 8)), np.zeros((8, 8))
        whirl, consistent = np.zeros((8, 8)), h / 6 * np.array([[2, 1], [1, 2]])
        for axis in (0, 1):
            w, a = [axis, 4 + axis], [2 + axis, 6 + axis]
            rise, slope, curve = np.zeros(8), np.zeros(8), np.zeros(8)
            rise[w], slope[a], curve[a] = [-1 / h, 1 / h], 0.5, [-1 / h, 1 / h]
            spring += h * (bending * np.outer(curve, curve) + shear * np.outer(rise - slope, rise - slope))
            tension += h * (segment.axial_force + self.rotor.axial_force) * np.outer(rise, rise)
            inertia[np.ix_(w, w)] += line * consistent
            if segment.rotary_inertia:
                inertia[np.ix_(a, a)] += turn * consistent
        if segment.gyroscopic:
            whirl[np.ix_([2, 6], [3, 7])] += 2 * turn * consistent
            whirl[np.ix_([3, 7], [2, 6])] -= 2 * turn * consistent
        turned = np.kron(np.eye(4), [[0.0, -1.0], [1.0, 0.0]])  # z × q
        inside = segment.internal_damping + self.rotor.internal_damping
        of_mass, of_spring = segment.standing_damping
        omega, rate = self.omega, 1j * self.omega
        block = spring + tension - omega**2 * inertia + rate * omega * whirl
        block = block + inside * spring @ (rate * np.eye(8) - omega * turned)
        self._add(4 * node + np.arange(8), block + rate * (of_mass * inertia + of_spring * spring))

    def _join(self, node, coupling):
        (kx, ky), (about_x, about_y) = (
            (np.array(still) + 1j * self.omega * np.array(moving))
            for still, moving in (
                (coupling.stiffness, coupling.damping),
                (coupling.angular_stiffness, coupling.angular_damping),
            )
        )
        self._add(4 * node + np.arange(8), np.kron([[1, -1], [-1, 1]], np.diag([kx, ky, about_y, about_x])))
        for end in (0, 1):
            values = (coupling.masses[end], coupling.polar_inertias[end], coupling.diametral_inertias[end])
            self._carry(node + end, *values)

    def _carry(self, node, mass, polar, diametral):
        block = -(self.omega**2) * np.diag([mass, mass, diametral, diametral]).astype(complex)
        block[2, 3], block[3, 2] = 1j * self.omega**2 * polar, -1j * self.omega**2 * polar
        self._add(4 * node + np.arange(4), block)

    def _hold(self, number, bearing):
        dofs = 4 * self._node(bearing.position) + np.arange(2)
        film = self._impedance(bearing)
        if bearing.table is not None:
            speeds, factors = np.array(bearing.table.speed), np.array(bearing.factors)
            row = PchipInterpolator(speeds, np.array(bearing.table.rows))(np.clip(self.omega, speeds[0], speeds[-1]))
            k, c, m = (factors * row).reshape(3, 2, 2)
            film = film + k + 1j * self.omega * c - self.omega**2 * m
        if bearing.pedestal is None:
            self._add(dofs, film)
            return
        self.housings[number] = housing = 4 * self.n_node + 2 * len(self.housings) + np.arange(2)
        self._add([*dofs, *housing], np.kron([[1, -1], [-1, 1]], film))
        self._add(housing, self._impedance(bearing.pedestal, bearing.pedestal.loss_factor))

    def _impedance(self, part, loss=0.0):
        k, c, m = (np.array([getattr(part, kind + entry) for entry in ENTRIES]).reshape(2, 2) for kind in "kcm")
        return k * (1 + 1j * loss) + 1j * self.omega * c - self.omega**2 * m

    def read(self, channels):
        size = 4 * self.n_node + 2 * len(self.housings)
        rows, columns, values = (np.concatenate(part) for part in zip(*self.entries, strict=True))
        whole = scipy.sparse.csc_matrix((values, (rows, columns)), shape=(size, size))
        force = np.zeros(size, dtype=complex)
        for plane in self.rotor.unbalance:
            size_of_force = plane.magnitude * self.omega**2 * np.exp(1j * plane.phase)
            force[4 * self._node(plane.position) + np.arange(2)] += size_of_force * np.array([1, -1j])
        motion = scipy.sparse.linalg.spsolve(whole, force)
        read = []
        for channel in channels:
            axis = "xy".index(channel.direction)
            value = motion[4 * self._node(channel.position) + axis]
            for probe in self.rotor.housing_probes:
                if probe.position == channel.position and probe.direction in (None, channel.direction):
                    value = value - motion[self.housings[probe.bearing][axis]]
            read.append(value)
        return read


def _between(ring, name, fraction):
    left, right = getattr(ring, name), getattr(ring, f"{name}_right")
    return left if right is None else left + (right - left) * fraction
