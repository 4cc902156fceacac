"""Uniform beams and what beam theory says of them on two pins."""

import numpy as np

from problems.rotor.finite_elements.assembly import assemble_free, node_dof
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.segments import Material, ShaftSegment
from problems.rotor.finite_elements.shaft import shear_coefficient
from problems.rotor.free_motion.modes import frequency_curves

STEEL = Material(young_modulus=200e9, density=7800.0, poisson_ratio=0.3)


def uniform(n_element, radius=0.01, length=1.0, shear_flexibility=1.0):
    return Rotor((ShaftSegment(length, radius, STEEL, n_element, shear_flexibility=shear_flexibility),))


def pinned(rotor):
    """The matrices of a rotor whose ends do not move."""
    matrices, last = assemble_free(rotor), len(rotor.node_positions) - 1
    keep = np.setdiff1d(np.arange(len(matrices.mass)), [*node_dof(0)[:2], *node_dof(last)[:2]])
    return matrices.on(np.eye(len(matrices.mass))[:, keep])


def natural_frequencies(matrices, speed):
    """Damped frequencies at a spin speed, (n_dof,) rad/s, rising."""
    return frequency_curves(matrices)(np.array([speed]))[0]


def euler_load(beam):
    """π²EI/L², N."""
    [segment] = beam.segments
    return np.pi**2 * segment.material.young_modulus * segment.second_moment / segment.length**2


def frequencies_of_a_pinned_beam(beam, n, axial_force=0.0, shear_flexibility=0.0, rotary=False):
    """The first n natural frequencies at rest, rad/s; an axial force of Euler and Bernoulli's beam alone.

    With w = W sin βz and ψ = Ψ cos βz: (κGA β² − μω²) W − κGA β Ψ = 0, −κGA β W + (EI β² + κGA − ρI ω²) Ψ = 0, and without
    shear ψ = dw/dz.
    """
    [segment] = beam.segments
    bending = segment.material.young_modulus * segment.second_moment
    mass, inertia = segment.material.density * np.array([segment.area, segment.second_moment * rotary])
    beta = np.arange(1, n + 1) * np.pi / segment.length
    if not shear_flexibility:
        return np.sqrt((bending * beta**4 + axial_force * beta**2) / (mass + inertia * beta**2))
    shear = shear_coefficient(segment) * segment.material.shear_modulus * segment.area / shear_flexibility
    determinants = [
        np.polysub(np.polymul([-mass, shear * b**2], [-inertia, bending * b**2 + shear]), [(shear * b) ** 2])
        for b in beta
    ]
    return np.array([np.sqrt(np.min(np.roots(each).real)) for each in determinants])
