"""How often the true site is accepted, how much of the shaft is, and what the stiffnesses are beside it: per hidden cause.

    OPENBLAS_NUM_THREADS=1 python benchmarks/location_rates.py 10 [CAUSE …]

Three-disk rotor, probes in x and y at 0.1, 0.5 and 1.0 m, 66 speeds, complex data with 5 to 7 % noise and a floor of
0.1 µm, neither of which the fit is told. The data come from the dense route with 26 elements, and what is hidden is put into
its matrices here: at one place, and by no effect of the library. A run takes about 10 s.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.load import Load
from ksmea.measurement import Measurement, Noise, observe
from ksmea.records.location import LocationRecord
from ksmea.studies.locate import location
from problems.rotor import dense
from problems.rotor.assembly import assemble
from problems.rotor.data import Rotor
from problems.rotor.loads import unit_loads
from problems.rotor.unbalance import complex_unbalance, force_per_unbalance
from problems.rotor.unknowns import rotor_at
from problems.three_disk import ThreeDisk

SENSORS, N_SPEED = [0.1, 0.5, 1.0], 66
TRUTH = np.array([50e6, 70e6, 500.0, 700.0, 2e-4])
FLOOR, RELATIVES = 1e-7, (0.05, 0.06, 0.07)
DISKS, BEARINGS = (0.2, 0.5, 1.0), (0.0, 1.3)
FINE = ThreeDisk(mesh=26, sensors=SENSORS, n_speed=N_SPEED).build()
PROBLEM = ThreeDisk(sensors=SENSORS, n_speed=N_SPEED).build()
SPEED = FINE.speed


SUMMARIES = [np.mean, np.mean, *[np.median] * 5, np.mean, np.mean, np.median]  # of the columns of `row`


class Hidden(NamedTuple):
    """Where something acts and what: a load (n_speed, 2) of its own, and an impedance (n_speed, 2, 2) to the motion there."""

    kind: str
    position: float
    load: ComplexArray
    impedance: ComplexArray


def nothing(rng: np.random.Generator) -> Hidden:
    return acting("nothing", 0.0)


def unbalance(rng: np.random.Generator) -> Hidden:
    """On another disk than the model's, 15 to 100 % of its."""
    size = 2e-4 * rng.uniform(0.15, 1.0) * np.exp(1j * rng.uniform(0, 2 * np.pi))
    return acting("force", rng.choice([0.2, 1.0]), load=size * SPEED[:, None] ** 2 * [1, -1j])


def cross_coupling(rng: np.random.Generator) -> Hidden:
    """At one bearing, antisymmetric, half to all of the 0.5 MN/m at which this rotor is no longer stable."""
    size = rng.choice([-1, 1]) * rng.uniform(0.25e6, 0.45e6)
    return acting("force", rng.choice(BEARINGS), impedance=size * np.array([[0, 1], [-1, 0]]))


def pedestal(rng: np.random.Generator) -> Hidden:
    """Under one bearing, 0.2 to 1 times as soft as it, with a mass of 2 to 10 kg."""
    bearing = np.diag(TRUTH[:2]) + 1j * SPEED[:, None, None] * np.diag(TRUTH[2:4])
    soft, mass = np.exp(rng.uniform(np.log(0.2), 0.0)) / 70e6, rng.uniform(2, 10)
    compliance = (soft / (1 + 0.02j - soft * SPEED**2 * mass))[:, None, None]
    in_series = np.linalg.solve(np.eye(2) + bearing * compliance, bearing)
    return acting("force", rng.choice(BEARINGS), impedance=in_series - bearing)


def mass(rng: np.random.Generator) -> Hidden:
    """3 to 20 kg anywhere."""
    added = -rng.uniform(3, 20) * SPEED[:, None, None] ** 2 * np.eye(2)
    return acting("force", rng.choice(PROBLEM.sites), impedance=added)


def moment(rng: np.random.Generator) -> Hidden:
    """A disk that is askew."""
    size = 2e-4 * rng.uniform(0.05, 0.3) * np.exp(1j * rng.uniform(0, 2 * np.pi))
    return acting("moment", rng.choice(DISKS), load=size * SPEED[:, None] ** 2 * [1, -1j])


def acting(
    kind: str, position: float, load: Array | ComplexArray | int = 0, impedance: Array | ComplexArray | int = 0
) -> Hidden:
    shape = (len(SPEED), 2)
    return Hidden(kind, float(position), np.zeros(shape) + load, np.zeros((*shape, 2)) + impedance + 0j)


CAUSES: dict[str, Callable[[np.random.Generator], Hidden]] = {
    each.__name__: each for each in (nothing, unbalance, cross_coupling, pedestal, mass, moment)
}


def response(rotor: Rotor, hidden: Hidden) -> ComplexArray:
    """What the rotor shows, (n_speed, n_channel) m."""
    kind = "force" if hidden.kind == "nothing" else hidden.kind
    at_site = unit_loads(rotor, [Load(hidden.position, axis, kind) for axis in "xy"], len(SPEED))
    stiffness = dense.dynamic_stiffness(assemble(rotor), SPEED) + at_site @ hidden.impedance @ np.swapaxes(
        at_site, 1, 2
    )
    force = force_per_unbalance(rotor, SPEED) @ complex_unbalance(rotor) + (at_site @ hidden.load[..., None])[..., 0]
    return np.linalg.solve(stiffness, force[..., None])[..., 0] @ dense.channel_rows(rotor, FINE.channels).T


def located(cause: str, seed: int) -> tuple[Hidden, LocationRecord, float]:
    """What was hidden, what was found, and in how many seconds of this process."""
    rng = np.random.default_rng([seed, *cause.encode()])
    hidden = CAUSES[cause](rng)
    values = response(rotor_at(FINE.rotor, FINE.unknowns, TRUTH), hidden)
    noisy = observe(values, "complex", Noise(RELATIVES[seed % len(RELATIVES)], FLOOR), rng)
    started = time.process_time()
    record = location(PROBLEM, Measurement(SPEED, FINE.channels, noisy, None, cause), rng)
    return hidden, record, time.process_time() - started


def row(cause: str, seed: int) -> list[float]:
    """Whether the true site is accepted, whether the plain model is, part of the sites of its kind that is accepted, errors of
    kxx and kyy by the plain model and beside the unknown (%), whether the intervals over sites hold them, seconds."""
    hidden, record, seconds = located(cause, seed)
    of_kind = [site for site in record.candidates if site.kind == hidden.kind]
    is_true = [site.accepted for site in of_kind if np.isclose(site.position, hidden.position)]
    found = [
        float(any(is_true)),
        float(record.kind == "nothing"),
        np.mean([site.accepted for site in of_kind] or [np.nan]),
    ]
    truth = PROBLEM.parameters.in_units(TRUTH)[:2]
    for estimates in ([each.plain for each in record.coefficients], [each.best for each in record.coefficients]):
        found += [
            np.nan if each is None else 100 * abs(each.value / value - 1) for each, value in zip(estimates, truth)
        ]
    for each, value in zip(record.coefficients, truth):
        over = each.over_sites
        found.append(np.nan if over is None else float((over.low or -np.inf) <= value <= (over.high or np.inf)))
    return [*found, seconds]


def main(n_draw: int, causes: list[str]) -> None:
    head = ["site", "plain", "share", "kxx, plain", "kyy, plain", "kxx %", "kyy %", "holds kxx", "kyy", "s"]
    print(f"{'cause':>15}" + "".join(f"{each:>12}" for each in head))
    for cause in causes or list(CAUSES):
        rows = np.array([row(cause, seed) for seed in range(n_draw)])
        shown = [
            summary(column[np.isfinite(column)]) if np.any(np.isfinite(column)) else np.nan
            for summary, column in zip(SUMMARIES, rows.T)
        ]
        print(f"{cause:>15}" + "".join(f"{each:>12.3g}" for each in shown), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2:])
