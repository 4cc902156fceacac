"""Time of a reduction of the three-disk rotor by banded elimination against dense elimination, both in one run, by mesh;
and how far the receptances part.

    OPENBLAS_NUM_THREADS=1 python benchmarks/reduction.py

An effect that changes the rotor itself (its mass, its modulus) costs a reduction per value. Times depend on the machine
and on what else it does; the ratio, from alternated repeats, is what the script is for.
"""

from __future__ import annotations

import time
from statistics import median

import numpy as np

from problems.rotor.receptance import reduce_rotor
from problems.three_disk import ThreeDisk

MESHES = (13, 26, 52, 104)
N_REPEAT = 7


def compared(mesh: int) -> tuple[float, float, float]:
    """Median seconds of either route, and the largest difference of the receptances relative to the largest one."""
    problem = ThreeDisk(mesh=mesh).build()
    impedances = problem.reduction.impedances
    by_dense = problem.reduction.receptance
    seconds: dict[str, list[float]] = {"banded": [], "dense": []}
    for _ in range(N_REPEAT):
        started = time.perf_counter()
        reduced = reduce_rotor(problem.rotor, impedances, problem.speed, problem.channels, banded=True)
        seconds["banded"].append(time.perf_counter() - started)
        started = time.perf_counter()
        reduce_rotor(problem.rotor, impedances, problem.speed, problem.channels)
        seconds["dense"].append(time.perf_counter() - started)
    difference = np.abs(reduced.receptance - by_dense).max() / np.abs(by_dense).max()
    return median(seconds["banded"]), median(seconds["dense"]), float(difference)


def main() -> None:
    print(f"{'mesh':>5}{'banded ms':>11}{'dense ms':>10}{'dense / banded':>16}{'largest difference':>20}")
    for mesh in MESHES:
        banded, full, difference = compared(mesh)
        print(f"{mesh:5d}{1e3 * banded:11.2f}{1e3 * full:10.2f}{full / banded:16.1f}{difference:20.1e}")


if __name__ == "__main__":
    main()
