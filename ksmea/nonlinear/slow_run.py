"""Which of several steady motions a slow run may be on, speed by speed.

A force that stiffens holds a resonance back: on the large motion the rotor is stiffer than its frequency asks, with fewer negative
eigenvalues of Z + K than of Z + Zᴴ alone, where Z is the dynamic stiffness at the sites and K the mean stiffness of the force on the
orbit. How many fewer is the number of resonances that are held back. It can rise only by resonances that the run has passed since the
last speed; large motions of their own, which no slow run comes to, hold back more. A force that softens does the same to a speed that
falls, with all signs changed over.
"""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices, Mask
from ksmea.nonlinear.harmonic_balance import Balance


def n_held(rotation: Balance, stiffness: ComplexArray, motion: Array, stiffens: Array) -> Indices:
    """How many resonances each motion (n, p) at the frequency of rotation holds back, (n,)."""
    m = stiffness.shape[1]
    _, by_motion = rotation.acting(motion)
    (real, from_imag), (to_imag, imag) = by_motion.reshape(-1, 2, m, 2, m).transpose(1, 3, 0, 2, 4)
    mean = (real + imag + 1j * (to_imag - from_imag)) / 2
    change = n_negative(stiffness) - n_negative(stiffness - mean)
    return np.maximum(np.where(stiffens < 0, -change, change), 0)


def n_negative(stiffness: ComplexArray) -> Indices:
    """Negative eigenvalues of the Hermitian part, (n,)."""
    hermitian = (stiffness + stiffness.conj().swapaxes(1, 2)) / 2
    return np.asarray(np.sum(np.linalg.eigvalsh(hermitian) < 0, axis=1))


def most_held(
    speed: Array, stiffens: Array, negative: Indices, point: Indices, held: Indices, is_stable: Mask
) -> Indices:
    """Largest number of resonances that a run may hold back at each speed, (n, n_speed).

    Speeds rise if the force stiffens (n,) and fall if it softens. `negative` (n, n_speed) counts the negative
    eigenvalues of the rotor alone. Motions are at a `point` each of all n n_speed, hold back `held` and may be
    stable."""
    n, n_speed = negative.shape
    softens = stiffens < 0
    row, column = np.divmod(point, n_speed)
    limit = np.zeros((n, n_speed), dtype=int)
    for sign, chosen in ((1, ~softens), (-1, softens)):
        before, last = np.zeros(n, dtype=int), np.full(n, 0 if sign > 0 else negative.max(initial=0))
        for index in np.argsort(sign * speed):
            most = before + np.maximum(sign * (negative[:, index] - last), 0)
            here = (column == index) & is_stable & (held <= most[row])
            before = np.zeros(n, dtype=int)
            np.maximum.at(before, row[here], held[here])
            last = negative[:, index]
            limit[chosen, index] = most[chosen]
    return limit
