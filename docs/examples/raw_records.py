"""Write five raw files of one machine, the rotor of problem=three_disk, as five instruments would.

    python docs/examples/raw_records.py records

Run-ups of 30 s from 220 to 1400 rad/s, probes 1X and 1Y at 0.1 m, 2X and 2Y at 0.5 m, 0.5 µm of noise in each sample. The vibration
at each moment is the steady state at its speed. The TDMS file takes npTDMS.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.io import savemat

import ksmea

NAMES = ("1X", "1Y", "2X", "2Y")
LOWEST, HIGHEST, DURATION, NOISE = 220.0, 1400.0, 30.0, 0.5  # rad/s, s, µm
A_TURN, TURNS = 128, 16  # samples of a System 1 waveform


def responses():
    """1X vectors (µm zero to peak) of the four probes at speeds in rad/s."""
    rotor = ksmea.load_problem(
        "three_disk", sensors=[0.1, 0.5], n_speed=6000, speed_from=LOWEST - 10, speed_to=HIGHEST + 10
    )
    data = ksmea.synthetic_measurement(rotor, kind="complex").measurement
    return lambda speed: np.stack([np.interp(speed, data.speed, each) for each in 1e6 * data.values.T], axis=-1)


def run_up(vectors, rng, steps):
    """Time (s), speed (rad/s), turns and motion (µm) at samples whose steps (s) are given."""
    time = np.cumsum(steps)
    rate = (HIGHEST - LOWEST) / time[-1]
    speed, angle = LOWEST + rate * time, LOWEST * time + rate * time**2 / 2
    motion = (vectors(speed) * np.exp(1j * angle)[:, None]).real + NOISE * rng.standard_normal((len(time), len(NAMES)))
    return time, speed, angle / (2 * np.pi), motion


def system1(vectors, rng) -> str:
    """Waveforms at 40 steady speeds: 16 turns of 128 samples from the keyphasor on, of each probe."""
    lines = []
    angle = 2 * np.pi * np.arange(A_TURN * TURNS) / A_TURN
    for number, speed in enumerate(np.linspace(LOWEST, HIGHEST, 40)):
        for name, vector in zip(NAMES, vectors(speed)):
            wave = (vector * np.exp(1j * angle)).real + NOISE * rng.standard_normal(len(angle))
            lines += ["Machine Name,Three disks", f"Point Name,{name}", "X-Axis Unit,ms", "Y-Axis Unit,µm"]
            lines += [f"Sample Speed, {speed * 30 / np.pi:.1f} rpm", f"Timestamp,5/17/2024 9:{10 + number}:00 AM"]
            lines += [f"Variable,Disp Wf({A_TURN}X/{TURNS}revs).KPH", "X-Axis Value,Y-Axis Value"]
            lines += [f"{1e3 * at / speed:.3f},{value:.3f}" for at, value in zip(angle, wave)]
    return "\n".join(lines) + "\n"


def matlab(vectors, rng, path: Path) -> None:
    """Write vectors of 60 speeds as MATLAB saves a table.

    The commands are `s = table2struct(T, 'ToScalar', true); save('run.mat', 's')`.
    """
    speed = np.linspace(LOWEST, HIGHEST, 60)
    values = vectors(speed) * (1 + 0.03 * rng.standard_normal((60, len(NAMES), 2)) @ [1, 1j] / np.sqrt(2))
    columns = {"speed_rpm": speed * 30 / np.pi}
    for name, each in zip(NAMES, values.T):
        columns |= {f"A{name}_um_pp": 2 * np.abs(each), f"lag{name}_deg": -np.angle(each, deg=True)}
    savemat(path, {"s": columns})


def tdms(vectors, rng, path: Path) -> None:
    """6 kHz, with a trigger that is on for half a turn."""
    from nptdms import ChannelObject, TdmsWriter

    step = 1 / 6000
    _, _, turns, motion = run_up(vectors, rng, np.full(int(DURATION / step), step))
    with TdmsWriter(str(path)) as writer:
        channels = [
            ("Trigger", np.where(turns % 1 < 0.5, 5.0, 0.0), "V"),
            *((n, m, "um") for n, m in zip(NAMES, motion.T)),
        ]
        writer.write_segment(
            [
                ChannelObject("Data", name, values, {"wf_increment": step, "unit_string": unit})
                for name, values, unit in channels
            ]
        )


def csv(path: Path, heading: str, *columns) -> None:
    np.savetxt(path, np.column_stack(columns), "%.6f", ",", header=heading, comments="")


def main(folder: Path) -> None:
    folder.mkdir(exist_ok=True)
    vectors, rng = responses(), np.random.default_rng(8)
    (folder / "waveforms.csv").write_text(system1(vectors, rng), encoding="utf-8")
    matlab(vectors, rng, folder / "table.mat")
    probes = ",".join(f"{name}_um" for name in NAMES)
    time, _, turns, motion = run_up(vectors, rng, rng.uniform(204e-6, 216e-6, int(DURATION / 210e-6)))
    csv(folder / "logger.csv", f"time_s,keyphasor,{probes}", time, np.where(turns % 1 < 0.05, 5.0, 0.0), motion)
    time, speed, _, motion = run_up(vectors, rng, np.full(180_000, 1 / 6000))
    csv(folder / "unmarked.csv", f"time_s,speed_rpm,{probes}", time, speed * 30 / np.pi, motion)
    try:
        tdms(vectors, rng, folder / "record.tdms")
    except ImportError:
        print("record.tdms: left out, as npTDMS is not installed (pip install 'ksmea-bench[formats]')")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
