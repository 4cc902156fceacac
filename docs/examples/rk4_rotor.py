"""Contribution of a rotor model to the weight campaign of the RK-4 rig.

It predicts from one speed to the other, and from three trial runs.

    python docs/examples/rk4_rotor.py features.csv

The model is `problem=rk4_two_disk` with the supports from its public run-up (docs/rk4.md): only one complex gain of each
probe is fitted to the campaign. B047, whose second weight is missing, is left out.
"""

import argparse
import csv
from pathlib import Path

import numpy as np

import ksmea

PROBES = ("plane1_x", "plane1_y", "plane2_x", "plane2_y")
SUPPORTS = {  # MN/m, kN s/m, of the swept model fitted to the run-up
    "beam_model": {"kxx": 0.0680, "kyy": 0.0822, "cxx": 0.0348, "cyy": 0.0226},
    "bearing_centres_560": {"kxx": 0.1277, "kyy": 0.1803, "cxx": 0.1154, "cyy": 0.2634},
}
SENSORS = {"beam_model": [0.12, 0.44], "bearing_centres_560": [0.08, 0.48]}  # m
TRIAL_RUNS = ("BASE", "A004", "A012")  # bare, 24 g mm on the first disk, 24 g mm on the second
MIL = 25.4  # µm
LARGE = 24.0  # g mm, from which angles are compared


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("features", type=Path)
    names, weights, responses, speeds = read(parser.parse_args().features)
    of_data = coefficients(weights, responses)
    for layout in SUPPORTS:
        by_model = influence(layout, speeds)
        print(
            f"{layout}\n  coefficients of {speeds[0]:.0f} rpm, taken to {speeds[1]:.0f} rpm, µm rms of what weights do there:"
        )
        measured = weights @ of_data[:, 1]
        for how, factor in (
            ("by the rotor model", by_model[:, 1] / by_model[:, 0]),
            ("by Ω²", (speeds[1] / speeds[0]) ** 2),
        ):
            print(f"    {how:20}{rms(weights @ (of_data[:, 0] * factor) - measured):.2f} of {rms(measured):.2f}")
        from_trials(names, weights, responses, by_model)


def from_trials(names: list[str], weights: np.ndarray, responses: np.ndarray, by_model: np.ndarray) -> None:
    """Weights of all other conditions from three trial runs.

    They are by influence coefficients and with the model's.
    """
    bare, first, second = (names.index(name) for name in TRIAL_RUNS)
    change = np.array([responses[first] - responses[bare], responses[second] - responses[bare]])
    of_trials = change / np.array([weights[first, 0], weights[second, 1]])[:, None, None]  # (plane, speed, probe)
    gain = np.sum(np.conj(by_model) * of_trials, axis=(0, 1)) / np.sum(np.abs(by_model) ** 2, axis=(0, 1))
    others = [index for index in range(len(names)) if index not in (bare, first, second)]
    print("  weights from three trial runs, RMSE of size (g mm) and mean error of angle:")
    for how, found in (("influence", of_trials), ("rotor model, gains", by_model * gain)):
        away = (responses - responses[bare]).reshape(len(names), -1)
        told, known = (away @ np.linalg.pinv(found.reshape(2, -1)))[others], weights[others]
        large = np.abs(known) >= LARGE
        angle = np.degrees(np.abs(np.angle(told[large] / known[large])))
        print(f"    {how:20}{rms(np.abs(told) - np.abs(known)):.1f}, {np.mean(angle):.0f}°")


def coefficients(weights: np.ndarray, responses: np.ndarray) -> np.ndarray:
    """Influence coefficients (plane, speed, probe) µm/(g mm) by least squares over all conditions."""
    columns = np.column_stack([np.ones(len(weights)), weights])
    found = np.linalg.lstsq(columns, responses.reshape(len(weights), -1), rcond=None)[0]
    return found[1:].reshape(2, 2, -1)


def influence(layout: str, speeds: np.ndarray) -> np.ndarray:
    """Influence coefficients of the rotor model: its response is linear in unbalance."""
    rotor = ksmea.load_problem("rk4_two_disk", layout=layout, sensors=SENSORS[layout], directions=["x", "y"])
    bare = {**SUPPORTS[layout], "u1": 1.0, "phase1": 0.0, "u2": 1.0, "phase2": 0.0}  # g mm, deg
    runs = [bare, {**bare, "u1": 2.0}, {**bare, "u2": 2.0}]
    without, *with_one = (1e6 * rotor.response(values, speed=speeds * np.pi / 30) for values in runs)
    return np.array(with_one) - without


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.abs(values) ** 2)))


def read(features: Path) -> tuple[list[str], np.ndarray, np.ndarray, np.ndarray]:
    """Conditions, weights (n, plane) g mm, responses (n, speed, probe) µm and mean speeds rpm.

    Angles of the file are lags, and its mounting angles run against the rotation: both change their sign.
    """
    with features.open() as file:
        rows = [row for row in csv.DictReader(file) if row["condition_id"] != "B047"]
    names = sorted({row["condition_id"] for row in rows})
    of = {name: [row for row in rows if row["condition_id"] == name] for name in names}
    weights = np.array([[value(of[name][0], plane) for plane in ("U1", "U2")] for name in names])
    responses, speeds = [], []
    for speed in ("N1", "N2"):
        at = [[row for row in of[name] if row["speed_id"] == speed] for name in names]
        responses.append(
            [[MIL * np.mean([value(row, f"{probe}_1x") for row in here]) for probe in PROBES] for here in at]
        )
        speeds.append(np.mean([float(row["rpm"]) for here in at for row in here]))
    return names, weights, np.array(responses).swapaxes(0, 1), np.array(speeds)


def value(row: dict[str, str], name: str) -> complex:
    return complex(float(row[f"{name}_re"]), -float(row[f"{name}_im"]))


if __name__ == "__main__":
    main()
