"""The three-disk rotor in numbers, for those who build it by other libraries.

Table 1 of Han, Guo & Gao (2013), doi 10.1016/j.jsv.2012.12.025, 13 equal shaft elements, SI.
"""

from __future__ import annotations

import numpy as np

N_ELEMENT, LENGTH, DIAMETER = 13, 1.3, 0.1  # m
DISKS = ((2, 0.24, 0.05), (5, 0.4, 0.05), (10, 0.4, 0.06))  # node, diameter and thickness in m
YOUNG, SHEAR, DENSITY = 200e9, 200e9 / 2.6, 7800.0  # Pa, Pa, kg/m³
BEARING_NODES, UNBALANCED_NODE, PROBE_NODE = (0, 13), 5, 1
LOWER = np.array([10e6, 10e6, 10.0, 10.0, 5e-5])  # kxx, kyy N/m; cxx, cyy N s/m; u kg m
UPPER = np.array([100e6, 100e6, 1000.0, 1000.0, 5e-4])
N_COMPARED = 100  # sets of unknowns that all sides evaluate, to be compared
TRUTH = np.array([50e6, 70e6, 500.0, 700.0, 2e-4])


def speeds(n: int) -> np.ndarray:
    """(n,) rad/s over the four critical speeds of the paper's band."""
    return np.linspace(200.0, 1500.0, n)


def drawn(n: int, seed: int = 0) -> np.ndarray:
    """Sets of unknowns (n, 5) between the limits; the first is the published one."""
    points = np.random.default_rng(seed).uniform(LOWER, UPPER, (n, 5))
    points[0] = TRUTH
    return points
