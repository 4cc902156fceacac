"""Rotors that nothing feeds energy to, which are stable at every speed: what spares the eigenvalues of most of them.

A free motion q e^{λt}, λ = σ + iω, of M, C, G, K with all that is attached leaves λ*(λ²M + λ(C + ΩG) + K + iH) q = 0 along q*,
H the hysteretic part of supports. Where K is symmetric and there is no circulatory matrix, the real part is

    σ (|λ|² m + k) = −(|λ|² c + ω h),      m, c, k, h the values of q*Mq, q*(C + Cᵀ)q/2, q*Kq and q*Hq,

in which gyroscopic matrices do no work. With c ≥ 0, k ≥ 0 and m > 0 no motion of ω ≥ 0 grows (Kelvin, Tait and Chetaev; F. Ziegler,
Principles of Structural Stability, 1968, section 3.4). Nor does one that hardly whirls, |ω| < |σ|, with loss factors below 1: h < k.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ksmea.arrays import Array
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.segments import ShaftSegment
from problems.rotor.free_motion.support import Support


def is_passive(
    rotor: Rotor,
    springs: Iterable[Array],
    dampers: Iterable[Array],
    masses: Iterable[Array],
    supports: Sequence[Support] = (),
) -> bool:
    """Whether nothing of a rotor can feed a free motion at any of the speeds at which its springs N/m, dampers N s/m and masses kg are
    given, (…, 2, 2) each; its own bearings are not looked at."""
    shaft = [segment for segment in rotor.segments if isinstance(segment, ShaftSegment)]
    shaft_takes_energy = (
        rotor.internal_damping == 0
        and all(segment.internal_damping == 0 for segment in shaft)
        and all(rotor.axial_force + segment.axial_force >= 0 for segment in shaft)
    )
    supports_take_energy = all(
        np.all(each.spring >= 0) and np.all(each.mass >= 0) and 0 <= each.loss_factor < 1 for each in supports
    )
    return bool(
        shaft_takes_energy
        and supports_take_energy
        and all(_is_symmetric(each) and _dissipates(each) for each in (*springs, *masses))
        and all(_dissipates(each) for each in dampers)
    )


def _is_symmetric(matrices: Array) -> bool:
    return bool(np.all(matrices[..., 0, 1] == matrices[..., 1, 0]))


def _dissipates(matrices: Array) -> bool:
    """Whether the symmetric parts of matrices (…, 2, 2) have no negative eigenvalue."""
    one, other = matrices[..., 0, 0], matrices[..., 1, 1]
    beside = (matrices[..., 0, 1] + matrices[..., 1, 0]) / 2
    return bool(np.all(one >= 0) and np.all(other >= 0) and np.all(one * other >= beside**2))
