"""The figure and the beats of the rig's run-up (docs/rk4.md).

The published data, and in both layouts the swept model that fits them.

    python docs/examples/rk4_run_up.py runup_bode_first_critical.csv rk4.png

The supports and rates are the final ones of that page's fits; the unbalance of both planes, in which the response is linear,
is fitted here, by least squares in units of the noise that the page states.
"""

import argparse
import csv
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.signal import find_peaks

import ksmea

SUPPORTS = {  # MN/m, kN s/m
    "beam_model": {"kxx": 0.0680, "kyy": 0.0822, "cxx": 0.0348, "cyy": 0.0226},
    "bearing_centres_560": {"kxx": 0.1277, "kyy": 0.1803, "cxx": 0.1154, "cyy": 0.2634},
}
RATE = {"beam_model": 167.0, "bearing_centres_560": 218.0}  # rpm/s
NOISE = {"beam_model": (0.15, 0.59), "bearing_centres_560": (0.21, 0.53)}  # of each value, and µm
SENSOR = {"beam_model": 0.12, "bearing_centres_560": 0.08}  # m, the same probe
RPM = np.pi / 30
SMOOTHED, PROMINENT = 3, 0.01  # rows of a mean, and the part of the largest amplitude by which a maximum stands out
BARE = {"u1": 1.0, "phase1": 0.0, "u2": 1.0, "phase2": 0.0}  # g mm, deg
SWEPT = """problem: {{name: rk4_two_disk, layout: {layout}, sensors: [{sensor}], directions: [x]}}
effects: [{{name: run_up_acceleration}}]
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run_up", type=Path)
    parser.add_argument("figure", type=Path)
    given = parser.parse_args()
    speed, measured = read(given.run_up)
    figure, panels = plt.subplots(2, len(SUPPORTS), figsize=(11, 6.6), sharex=True, sharey="row", layout="constrained")
    for (above, below), layout in zip(panels.T, SUPPORTS):
        draw(above, below, layout, speed, measured)
    panels[0, 0].set_ylabel("amplitude (µm 0-peak)")
    panels[1, 0].set_ylabel("phase lead (°)")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False)
    figure.savefig(given.figure, dpi=100)
    print("maxima, rpm\n  measured", *maxima(speed, np.abs(measured), SMOOTHED))
    for layout in SUPPORTS:
        print_beats(layout, speed, measured)


def print_beats(layout: str, speed: np.ndarray, measured: np.ndarray) -> None:
    """Maxima of the swept and the steady amplitude, critical speeds and damping ratios there."""
    fine = np.linspace(1300.0, 2200.0, 1801)
    unbalance = fitted_unbalance(layout, speed, measured)
    swept, steady = (np.abs(unit_responses(layout, rate, fine) @ unbalance) for rate in (RATE[layout], 0.0))
    print(f"  {layout}, {RATE[layout]:.0f} rpm/s:", *maxima(fine, swept), "steady:", *maxima(fine, steady))
    rotor = ksmea.load_problem("rk4_two_disk", layout=layout)
    critical = rotor.critical_speeds({**SUPPORTS[layout], **BARE}, highest=2500 * RPM) / RPM
    for each in critical:
        modes = rotor.modes(each * RPM, {**SUPPORTS[layout], **BARE})
        near = min(modes, key=lambda mode: abs(mode.frequency - each * RPM))
        print(f"    critical speed {each:.0f} rpm, damping ratio {near.damping_ratio:.3f}")


def maxima(speed: np.ndarray, amplitude: np.ndarray, rows: int = 1) -> list[int]:
    """Speeds (rpm) of the first seven maxima from 1600 rpm on, of the mean of so many rows."""
    mean = np.convolve(amplitude, np.ones(rows) / rows, mode="same")
    peaks, _ = find_peaks(mean, prominence=PROMINENT * mean.max())
    return [round(each) for each in speed[peaks] if each > 1600][:7]


def draw(above, below, layout: str, speed: np.ndarray, measured: np.ndarray) -> None:
    """Amplitude and phase over speed (rpm): measured, swept, and the same model without the sweep."""
    fine = np.linspace(1300.0, 2200.0, 361)
    unbalance = fitted_unbalance(layout, speed, measured)
    swept, steady = (unit_responses(layout, rate, fine) @ unbalance for rate in (RATE[layout], 0.0))
    curves = {"model, swept": (swept, "-"), "the same model, steady": (steady, ":")}
    for part, panel in ((np.abs, above), (phase, below)):
        panel.plot(speed, part(measured), "o", color="0.45", markersize=3, label="measured")
        for name, (values, style) in curves.items():
            panel.plot(fine, part(values), style, color="#c0392b", label=name)
        panel.grid(alpha=0.25)
        panel.set_xlim(fine[0], fine[-1])
    above.set_title(f"{layout}, {RATE[layout]:.0f} rpm/s")
    below.set_xlabel("speed (rpm)")


def fitted_unbalance(layout: str, speed: np.ndarray, measured: np.ndarray) -> np.ndarray:
    """Unbalance of both planes (2,) g mm with the swept model, by weighted least squares."""
    relative, floor = NOISE[layout]
    weight = 1 / np.hypot(relative * np.abs(measured), floor)
    return np.linalg.lstsq(weight[:, None] * unit_responses(layout, RATE[layout], speed), weight * measured)[0]


def unit_responses(layout: str, rate: float, speed: np.ndarray) -> np.ndarray:
    """The response in x at the probe to 1 g mm in each plane, (n_speed, 2) µm: what one more does."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "swept.yaml"
        file.write_text(SWEPT.format(layout=layout, sensor=SENSOR[layout]), encoding="utf-8")
        rotor = ksmea.load_problem(str(file))
        values = {**SUPPORTS[layout], **BARE, "acceleration": rate}
        runs = [values, {**values, "u1": 2.0}, {**values, "u2": 2.0}]
        without, *with_one = (1e6 * rotor.response(run, speed=speed * RPM)[:, 0] for run in runs)
    return np.column_stack(with_one) - without[:, None]


def phase(values: np.ndarray) -> np.ndarray:
    return np.degrees(np.unwrap(np.angle(values)))


def read(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Speeds (rpm) and responses (µm) between 1300 and 2200 rpm."""
    with path.open() as file:
        rows = [row for row in csv.DictReader(file) if 1300 <= float(row["rpm"]) <= 2200]
    amplitude, lead = (np.array([float(row[name]) for row in rows]) for name in ("amp_1x_um_0pk", "phase_1x_deg"))
    return np.array([float(row["rpm"]) for row in rows]), amplitude * np.exp(1j * np.radians(lead))


if __name__ == "__main__":
    main()
