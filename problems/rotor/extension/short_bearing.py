"""The oil film of a plain journal bearing that is short (Ocvirk).

Its eccentricity under a load, and its coefficients there.

A journal with diameter D, length L and radial clearance c turns at Ω in oil of viscosity η under a static load f.
Pressure falls off along the bearing only, is zero at its ends, and zero where the gap opens (laminar, L/D up to about
0.5). All depends on the modified Sommerfeld number S and on the eccentricity ratio ε that belongs to it,

    S = D Ω η L³ / (8 f c²) = (1 − ε²)² / (ε √(π² (1 − ε²) + 16 ε²)),      K = f/c a(ε),      C = f/(cΩ) b(ε).

Directions (u, v): v against the load, u a quarter turn behind in the sense of rotation, from u to v.

M. I. Friswell, J. E. T. Penny, S. D. Garvey & A. W. Lees, Dynamics of Rotating Machines, 2010, section 5.5;
G. B. DuBois & F. W. Ocvirk, Analytical derivation and experimental evaluation of short-bearing approximation for full journal
bearings, NACA Report 1157 (1953).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import scipy
from scipy.special import expit

from ksmea.arrays import Array

# Eccentricities from e^(-25) to 1 - e^(-14), as ln(ε/(1 − ε)), at which S is tabled: the inverse is right within 1e-9.
LOGIT_RANGE = (-25.0, 14.0)
N_TABLE = 4000


def modified_sommerfeld(eccentricity: Array) -> Array:
    """S at eccentricity ratios between 0 and 1, of any shape."""
    squared = eccentricity**2
    return np.asarray((1 - squared) ** 2 / (eccentricity * np.sqrt(np.pi**2 * (1 - squared) + 16 * squared)))


def eccentricity_ratio(sommerfeld: Array) -> Array:
    """ε at modified Sommerfeld numbers above 0, of any shape.

    >>> round(float(eccentricity_ratio(np.array(1.0098))), 4)  # Friswell et al. 2010, Example 5.5.1
    0.2663
    """
    inverse = _inverse()
    return np.asarray(expit(inverse(np.clip(np.log(sommerfeld), inverse.x[0], inverse.x[-1]))))


def film_coefficients(eccentricity: Array) -> tuple[Array, Array]:
    """Stiffness a = K c/f and damping b = C c Ω/f in (u, v), (2, 2, …), at eccentricity ratios (…)."""
    e, e2, pi, pi2 = eccentricity, eccentricity**2, np.pi, np.pi**2
    rest = 1 - e2
    h0 = (pi2 * rest + 16 * e2) ** -1.5
    root = np.sqrt(rest)
    a_uu = 4 * h0 * (pi2 * (2 - e2) + 16 * e2)
    a_uv = h0 * pi * (pi2 * rest**2 - 16 * e2**2) / (e * root)
    a_vu = -h0 * pi * (pi2 * rest * (1 + 2 * e2) + 32 * e2 * (1 + e2)) / (e * root)
    a_vv = 4 * h0 * (pi2 * (1 + 2 * e2) + 32 * e2 * (1 + e2) / rest)
    b_uu = 2 * pi * h0 * root * (pi2 * (1 + 2 * e2) - 16 * e2) / e
    b_uv = -8 * h0 * (pi2 * (1 + 2 * e2) - 16 * e2)
    b_vv = 2 * pi * h0 * (pi2 * rest**2 + 48 * e2) / (e * root)
    return np.array([[a_uu, a_uv], [a_vu, a_vv]]), np.array([[b_uu, b_uv], [b_uv, b_vv]])


@lru_cache(maxsize=1)
def _inverse() -> scipy.interpolate.CubicSpline:
    """ln(ε/(1 − ε)) as a function of ln S."""
    logit = np.linspace(*LOGIT_RANGE[::-1], N_TABLE)
    return scipy.interpolate.CubicSpline(np.log(modified_sommerfeld(expit(logit))), logit)
