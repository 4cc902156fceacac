"""Made campaigns of the three-disk rotor.

A bare run and one with a known weight, by the dense route on another mesh.
"""

import dataclasses

import numpy as np

from ksmea.measurement.campaign import Campaign, Run, Weight
from ksmea.measurement.measurement import Layout, Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.problem.alignment import aligned
from ksmea.units import DEGREE, GRAM_MILLIMETRE
from measurements.run_up_csv import as_csv
from problems.three_disk import ThreeDisk

TRIAL = Weight(1.0, 150 * GRAM_MILLIMETRE, 60 * DEGREE)
TRUTH = ThreeDisk().reference() | {"phase_origin": 0.6}
NOISE = Noise(0.05, 2e-8)


def layout_of(problem, speeds, runs, kind="complex", own=()):
    """A layout of runs, (name, weights) each, with their speeds."""
    counted = tuple(Run(name, len(speed), weights) for (name, weights), speed in zip(runs, speeds, strict=True))
    return Layout(np.concatenate(speeds), problem.channels, kind, "made", False, campaign=Campaign(counted, own))


def measured(problem, layout, truth=TRUTH, noise=NOISE, seed=1):
    """Measurement of the problem by the dense route, with noise of unknown level."""
    seen = aligned(problem, layout)
    x = np.array([truth[name] for name in seen.parameters.names])
    values = observe(seen.dense_response(x[None])[0], layout.kind, noise, np.random.default_rng(seed))
    return Measurement(layout.speed, layout.channels, values, None, "made", False, layout.campaign)


def write(folder, measurement, text=None):
    """A CSV file for each run, and a campaign.yaml that names them."""
    lines = ["runs:"]
    for run, rows in zip(measurement.campaign.runs, measurement.rows):
        part = dataclasses.replace(measurement.part(np.arange(rows.start, rows.stop)), campaign=None)
        (folder / f"{run.name}.csv").write_text(as_csv(part), encoding="utf-8")
        weights = ", ".join(
            f"{{position: {each.position:g}, g_mm: {each.magnitude / GRAM_MILLIMETRE:.6g},"
            f" angle_deg: {each.angle / DEGREE:.6g}}}"
            for each in run.weights
        )
        lines.append(f"  - {{name: {run.name}, file: {run.name}.csv, weights: [{weights}]}}")
    path = folder / "campaign.yaml"
    path.write_text("\n".join(lines) + "\n" if text is None else text, encoding="utf-8")
    return path
