"""What a location costs: CPU seconds against sites and speeds, and the exponents of a power law fitted to them.

    OPENBLAS_NUM_THREADS=1 python -m benchmarks.location_cost

Three-disk rotor, probes in x and y at 0.1, 0.5 and 1.0 m, complex data with 5 % noise; an unbalance on another disk, which its
law tells. The fit's mesh makes the sites: forces and moments at each node, and a reading at each plane. Runs of all sizes take
turns, three times; the median counts.
"""

from __future__ import annotations

import itertools
import time

import numpy as np

import ksmea

MESHES, SPEEDS, N_TURN = (7, 13, 26), (33, 66, 132), 3
NOISE = {"relative": 0.05, "floor": 0.1, "noise_known": False}


def seconds(mesh: int, n_speed: int) -> tuple[int, float]:
    """Sites that are tried, and CPU seconds of this process."""
    rotor = ksmea.load_problem("three_disk", mesh=mesh, sensors=[0.1, 0.5, 1.0], n_speed=n_speed)
    data = ksmea.synthetic_measurement(
        rotor, kind="complex", hidden=["unbalance"], mesh=26, route="dense", rng=1, **NOISE
    )
    started = time.process_time()
    found = ksmea.locate(rotor, data)
    return len(found.record.candidates), time.process_time() - started


def main() -> None:
    sizes = list(itertools.product(MESHES, SPEEDS))
    rows = np.array([[seconds(*size) for size in sizes] for _ in range(N_TURN)])
    sites, cost = rows[0, :, 0], np.median(rows[:, :, 1], axis=0)
    spread = np.ptp(rows[:, :, 1], axis=0)
    print("elements  sites  speeds  CPU s (range)")
    for (mesh, n_speed), n_site, each, width in zip(sizes, sites, cost, spread):
        print(f"{mesh:8d}  {n_site:5.0f}  {n_speed:6d}  {each:5.1f} ({width:.1f})")
    columns = np.column_stack([np.log(sites), np.log([n_speed for _, n_speed in sizes]), np.ones(len(sizes))])
    of_sites, of_speeds, _ = np.linalg.lstsq(columns, np.log(cost))[0]
    print(f"grows as sites^{of_sites:.2f} and speeds^{of_speeds:.2f}")


if __name__ == "__main__":
    main()
