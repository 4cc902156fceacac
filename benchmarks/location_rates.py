"""Rates at which a diagnosis without a library finds place, kind and law of a hidden cause.

They include whether its intervals hold, per hidden cause.

    OPENBLAS_NUM_THREADS=1 python -m benchmarks.location_rates 20 rows.csv [CAUSE …]
    python -m benchmarks.location_rates rows.csv

The first makes draws that the file does not have yet, in two processes, and writes a row for each; both print a table of them. Three-disk rotor, probes in x
and y at 0.1, 0.5 and 1.0 m, 66 speeds, complex data with 5 to 7 % noise and a floor of 0.1 µm, neither of which the fit is
told. The data come from the dense route with 26 elements. What acts at one place is put into its matrices here, by no effect
of the library, or is balanced with five harmonics; what is spread or in the readings is an effect of the library. A draw takes
about 10 s.
"""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.acting import response_with
from benchmarks.resumed import rows_of
from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import Observable
from ksmea.plugins import registry
from ksmea.problem.case import Case
from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.records.location import LocationRecord
from ksmea.studies.diagnose import diagnosis
from measurements.hidden_size import drawn_size
from problems.rotor.response import dense
from problems.rotor.response.unknowns import rotor_at
from problems.three_disk import ThreeDisk
from tests.helpers.harmonic_balance import balanced_response

SENSORS, N_SPEED = [0.1, 0.5, 1.0], 66
TRUTH = np.array([50e6, 70e6, 500.0, 700.0, 2e-4])
FLOOR, RELATIVES = 1e-7, (0.05, 0.06, 0.07)
DISKS, BEARINGS = (0.2, 0.5, 1.0), (0.0, 1.3)
FINE = ThreeDisk(mesh=26, sensors=SENSORS, n_speed=N_SPEED).build()
PROBLEM = ThreeDisk(sensors=SENSORS, n_speed=N_SPEED).build()
ROTOR, SPEED = rotor_at(FINE.rotor, FINE.unknowns, TRUTH), FINE.speed
CLEAR, STRONG = 60.0, 1000.0  # Δχ² of what is clearly, and strongly, visible
LARGEST_MOTION = 15e-6  # m, 0-peak


@dataclass(frozen=True)
class Hidden:
    """Cause that a response (n_speed, n_channel) m hides.

    `quantity` and `position` are of a cause at one place, with keys of the laws that describe it. `keeps` are the
    indices of the speeds that a machine would show, all if it is None.
    """

    response: ComplexArray
    quantity: str = ""
    position: float = np.nan
    laws: tuple[str, ...] = ()
    keeps: Indices | None = None


def acting(
    position: float,
    laws: tuple[str, ...],
    *,
    quantity: str = "force",
    load: Array | ComplexArray | int = 0,
    impedance: Array | ComplexArray | int = 0,
) -> Hidden:
    """A load (n_speed, 2) at a place, N or N m, and an impedance (n_speed, 2, 2) to the motion there, N/m."""
    response = response_with(ROTOR, SPEED, FINE.channels, position, quantity, load, impedance)
    return Hidden(response, quantity, float(position), laws)


def turning(rng: np.random.Generator, least: float, most: float) -> ComplexArray:
    """An unbalance of a part of the model's, at any angle: a load (n_speed, 2)."""
    size = TRUTH[-1] * rng.uniform(least, most) * np.exp(1j * rng.uniform(0, 2 * np.pi))
    return np.asarray(size * SPEED[:, None] ** 2 * [1, -1j])


def nothing(rng: np.random.Generator) -> Hidden:
    return acting(0.0, ())


def unbalance(rng: np.random.Generator) -> Hidden:
    """On another disk than the model's, 15 to 100 % of its."""
    return acting(rng.choice([0.2, 1.0]), ("unbalance",), load=turning(rng, 0.15, 1.0))


def cross_coupling(rng: np.random.Generator) -> Hidden:
    """At one bearing, antisymmetric, half to all of the 0.5 MN/m at which this rotor is no longer stable."""
    size = rng.choice([-1, 1]) * rng.uniform(0.25e6, 0.45e6)
    return acting(rng.choice(BEARINGS), ("cross_coupling",), impedance=size * np.array([[0, 1], [-1, 0]]))


def pedestal(rng: np.random.Generator) -> Hidden:
    """Under one bearing, 0.2 to 1 times as soft as it, with a mass of 2 to 10 kg: none of the simple laws."""
    bearing = np.diag(TRUTH[:2]) + 1j * SPEED[:, None, None] * np.diag(TRUTH[2:4])
    soft, mass = np.exp(rng.uniform(np.log(0.2), 0.0)) / 70e6, rng.uniform(2, 10)
    compliance = (soft / (1 + 0.02j - soft * SPEED**2 * mass))[:, None, None]
    in_series = np.linalg.solve(np.eye(2) + bearing * compliance, bearing)
    return acting(rng.choice(BEARINGS), (), impedance=in_series - bearing)


def added_mass(rng: np.random.Generator) -> Hidden:
    """3 to 20 kg anywhere."""
    added = -rng.uniform(3, 20) * SPEED[:, None, None] ** 2 * np.eye(2)
    return acting(rng.choice(PROBLEM.sites), ("mass",), impedance=added)


def stiffness(rng: np.random.Generator) -> Hidden:
    """A spring to the ground anywhere between the bearings, 1 to 10 MN/m in each direction."""
    added = np.diag(10 ** rng.uniform(6, 7, size=2))
    return acting(rng.choice(PROBLEM.sites[1:-1]), ("spring",), impedance=added)


def skewed_disk(rng: np.random.Generator) -> Hidden:
    """A moment that turns with the shaft and grows with Ω²."""
    return acting(rng.choice(DISKS), ("skew",), quantity="moment", load=turning(rng, 0.05, 0.3))


def stop(rng: np.random.Generator) -> Hidden:
    """A soft stop at a disk, 2 to 8 MN/m beyond 1 to 4 µm: no effect of the library does this."""
    stiff, clearance = rng.uniform(2e6, 8e6), rng.uniform(1e-6, 4e-6)

    def force_at(orbit: Array, turn: ComplexArray) -> Array:
        return -stiff * np.maximum(1 - clearance / np.linalg.norm(orbit, axis=-1, keepdims=True), 0) * orbit

    return balanced(rng.choice(DISKS), ("spring_above_an_amplitude", "rub"), force_at)


def hardening(rng: np.random.Generator) -> Hidden:
    """A cubic spring at a disk that is 5 to 20 MN/m at 15 µm."""
    cubic = rng.uniform(5e6, 20e6) / LARGEST_MOTION**2
    return balanced(
        rng.choice(DISKS),
        ("cubic_spring",),
        lambda orbit, turn: -cubic * np.sum(orbit**2, axis=-1, keepdims=True) * orbit,
    )


def balanced(position: float, laws: tuple[str, ...], force_at: Callable[[Array, ComplexArray], Array]) -> Hidden:
    """A force that is not linear in the motion.

    Beside the sharpest resonances its curves fold over, where a run-up jumps: speeds at which the site moves by 15 µm
    and more without it, and those that have no balance, are left out.
    """
    motion = dense.dense_response(ROTOR, SPEED, [Channel(position, axis) for axis in "xy"])
    keeps, found = [], []
    for index in np.flatnonzero(np.linalg.norm(motion, axis=1) < LARGEST_MOTION):
        with contextlib.suppress(AssertionError):
            found.append(balanced_response(ROTOR, SPEED[[index]], FINE.channels, position, force_at)[0])
            keeps.append(index)
    return Hidden(np.array(found), "force", float(position), laws, np.array(keeps))


def of_library(name: str) -> Callable[[np.random.Generator], Hidden]:
    """An effect that is spread along the shaft, or in the readings."""

    def hidden(rng: np.random.Generator) -> Hidden:
        effects = list(registry.create("effect", name, {}).locations(FINE))
        effect = effects[rng.integers(len(effects))]
        size = drawn_size(effect, FINE, TRUTH, Observable.COMPLEX, rng)
        is_read = name in ("channel_gain", "probe_rotation")
        response = effect.added_to(FINE).dense_response(np.append(TRUTH, size)[None])[0]
        return Hidden(response, "reading" if is_read else "", effect.position if is_read else np.nan)

    return hidden


LOCAL = (unbalance, cross_coupling, pedestal, added_mass, stiffness, stop, hardening, skewed_disk)
CAUSES: dict[str, Callable[[np.random.Generator], Hidden]] = {each.__name__: each for each in (nothing, *LOCAL)} | {
    name: of_library(name) for name in ("youngs_modulus", "mass", "channel_gain", "probe_rotation")
}


def row(cause: str, seed: int) -> dict[str, Any]:
    """One draw: what was hidden, what was found."""
    rng = np.random.default_rng([seed, *cause.encode()])
    hidden = CAUSES[cause](rng)
    noisy = observe(hidden.response, "complex", Noise(RELATIVES[seed % len(RELATIVES)], FLOOR), rng)
    speed = SPEED if hidden.keeps is None else SPEED[hidden.keeps]
    started = time.process_time()
    record = diagnosis(
        Case(PROBLEM.at(speed, PROBLEM.channels), Measurement(speed, FINE.channels, noisy, None, cause)), {}, rng
    )
    seconds = time.process_time() - started
    return {"cause": cause, "seed": seed, "seconds": seconds, "verdict": record.verdict} | _found(record, hidden)


def _found(record: DiagnosisRecord, hidden: Hidden) -> dict[str, Any]:
    """The location beside what was hidden; nothing where the plain model was enough."""
    truth = dict(zip(PROBLEM.parameters.names, PROBLEM.parameters.in_units(TRUTH)))
    row: dict[str, Any] = {"kind": hidden.quantity, "position": hidden.position}
    for each in record.coefficients:
        if each.before is not None:
            row[f"{each.name}_plain"] = each.before.value / truth[each.name] - 1
            row[f"{each.name}_plain_holds"] = each.before.holds(truth[each.name])
    if (where := record.location) is None:
        return row
    for coefficient in where.coefficients:
        if (over := coefficient.over_sites) is not None:
            row[coefficient.name] = over.value / truth[coefficient.name] - 1
            row[f"{coefficient.name}_holds"] = over.holds(truth[coefficient.name])
    of_quantity = [site for site in where.candidates if site.kind == hidden.quantity]
    return row | {
        "chi2_drop": where.plain.chi2 - where.plain.n_left,
        "site": any(site.accepted and np.isclose(site.position, hidden.position) for site in of_quantity),
        "share": np.mean([site.accepted for site in where.candidates]),
        "share_of_kind": np.mean([site.accepted for site in of_quantity]) if of_quantity else np.nan,
        "found_kind": where.kind,
        "found_sites": "; ".join(map(str, where.sites)),
        "one_site": len(where.sites) == 1,
        "law": "" if where.law is None else where.law.key,
        "law_sites": " ".join(f"{law.key}@{law.position:g}" for law in where.law_class),
        "law_right": _in_class(where, hidden.laws) if hidden.laws else np.nan,
    }


def _in_class(where: LocationRecord, keys: tuple[str, ...]) -> bool:
    """Whether a law is the reported one, or in its class."""
    return any(law.key in keys for law in where.law_class)


def summary(rows: pd.DataFrame) -> pd.DataFrame:
    """A line per cause.

    Counts are of draws with Δχ² of 60 and more, 'share' is the median where it is 1 000 and more.
    """
    lines = []
    for cause, mine in rows.groupby("cause", sort=False):
        seen = mine[mine["chi2_drop"] >= CLEAR]
        strong = mine[mine["chi2_drop"] >= STRONG]
        line = {"cause": cause, "draws": len(mine), **mine["verdict"].value_counts().to_dict(), "clear": len(seen)}
        line |= {name: seen[name].sum() for name in ("site", "one_site", "law_right")}
        line["kind"] = (seen["found_kind"] == seen["kind"]).sum()
        line["strong"], line["share"] = len(strong), strong["share"].median()
        for name in PROBLEM.parameters.names:
            line[f"{name} plain"] = seen[f"{name}_plain_holds"].sum()
            line[name] = seen[f"{name}_holds"].sum() if f"{name}_holds" in seen else np.nan
        line["seconds"] = mine["seconds"].median()
        lines.append(line)
    return pd.DataFrame(lines).fillna({"located": 0, "unknown": 0, "adequate": 0})


def main(arguments: list[str]) -> None:
    table = summary(rows_of(arguments, COLUMNS, row, CAUSES).sort_values("seed"))
    print(table.set_index("cause").T.to_string(float_format="{:.3g}".format))


COLUMNS = [
    *("cause", "seed", "seconds", "verdict", "kind", "position", "chi2_drop", "site", "share", "share_of_kind"),
    *("found_kind", "found_sites", "one_site", "law", "law_sites", "law_right"),
    *(f"{name}{part}" for name in PROBLEM.parameters.names for part in ("_plain", "_plain_holds", "", "_holds")),
]

if __name__ == "__main__":
    main(sys.argv[1:])
