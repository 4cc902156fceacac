"""Files of instruments with known vectors.

A writer for each format that the project reads, and the settings that read it.

The vectors are those of a run-up of a rotor with one resonance, `VALUES` (n_speed, 2) m zero to peak under Re(q e^{iΩt}), of probes
called A and B in x and y at 0.1 m.
"""

from __future__ import annotations

import io
import tempfile
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np

from measurements.file import File

SPEED = np.round(np.linspace(600.0, 3000.0, 25), 1)  # rpm
OMEGA = SPEED * np.pi / 30
RESONANCE = 180.0  # rad/s
VALUES = np.stack(
    [
        40e-6 * OMEGA**2 / (w**2 - OMEGA**2 + 0.1j * w * OMEGA) * turn
        for w, turn in ((RESONANCE, 1.0), (1.1 * RESONANCE, -1j))
    ],
    axis=1,
)
PLACES = ["A@0.1@x", "B@0.1@y"]
START = datetime(2024, 5, 17, 9, 30, 0)


@dataclass(frozen=True)
class Example:
    """A file, the settings that read it, and the relative precision of what it prints."""

    name: str
    content: bytes
    settings: dict[str, Any] = field(default_factory=dict)
    precision: float = 1e-9


def _lag(values):
    return np.mod(-np.angle(values, deg=True), 360)


def system1() -> Example:
    """Two points one below the other, mil peak to peak, lags, with columns of status and a time."""
    lines = []
    for number, name in enumerate("AB"):
        lines += ["Machine Name,Test rig", f"Point Name,{name}", "Comp,", "Probe Angle,0° Right"]
        lines += ["X-Axis Unit,rpm", "Y-Axis Unit,mil pp", "Variable,1X"]
        lines.append("X-Axis Value,Y-Axis Value,Y-Axis Status,Phase,Phase Status,Timestamp")
        for index, (speed, value) in enumerate(zip(SPEED, VALUES[:, number])):
            when = (START + timedelta(seconds=2 * index)).strftime("%m/%d/%Y %I:%M:%S %p")
            lines.append(f"{speed},{abs(value) * 2 / 25.4e-6:.12g},Valid,{_lag(value):.12g},Valid,{when}")
    settings = {"format": "system1", "probes": PLACES}
    return Example("bode.csv", ("\ufeff" + "\r\n".join(lines) + "\r\n").encode(), settings)


def adre() -> Example:
    """Blocks repeated before each sample, bars, UTF-16, with a keyphasor that has no vectors."""
    lines = ["", ""]
    for index, speed in enumerate(SPEED):
        when = (START + timedelta(seconds=2 * index)).strftime("%d%b%Y %H:%M:%S.468")
        lines += ["", "CH#|Channel Name|Machine Name|Status|Angle|Direction|Speed Units(P)|Amp Unit|Phase Unit|"]
        lines += [
            f"{n + 1}|{name}|RIG|OK|45°|{side}|rpm|µm pp|deg|"
            for n, (name, side) in enumerate(zip("AB", ("Right", "Left")))
        ]
        lines += ["3|KPH|RIG|OK|90°|Right|rpm|V pp|deg|", ""]
        lines += [
            "CH#|Channel Name|Sample#|Sample Cause|Date|Speed(P)|Speed(S)|Direct|1XAmplitude|1X Phase|2XAmplitude|2X Phase|"
        ]
        for n, name in enumerate("AB"):
            value = VALUES[index, n]
            lines.append(
                f"{n + 1}|{name}|{index + 1}|DT-R|{when}|{speed}|0|1.1|{abs(value) * 2e6:.12g}|{_lag(value):.12g}|0.2|25|"
            )
        lines.append(f"3|KPH|{index + 1}|DT-R|{when}|{speed}|0|10.6|||||")
    settings = {"format": "adre", "probes": PLACES}
    return Example("list.csv", ("\r\n".join(lines) + "\r\n").encode("utf-16"), settings)


WIDE = ["speed=N [1/min]", "amplitude.A=A (µm pp)", "phase.A=A deg", "amplitude.B=B (µm pp)", "phase.B=B deg"]


def csv_wide() -> Example:
    """Semicolons, decimal commas, Latin-1, µ in units, lines above the headings."""
    rows = ["Messung 12;;;;", "N [1/min];A (µm pp);A deg;B (µm pp);B deg"]
    for speed, (a, b) in zip(SPEED, VALUES):
        numbers = (speed, abs(a) * 2e6, _lag(a), abs(b) * 2e6, _lag(b))
        rows.append(";".join(f"{number:.12g}".replace(".", ",") for number in numbers))
    settings = {"format": "csv", "columns": WIDE, "probes": PLACES, "phase": "lag"}
    return Example("wide.csv", ("\n".join(rows) + "\n").encode("latin-1"), settings)


LONG = ["speed=Speed", "channel=Probe", "real=Re", "imag=Im"]


def csv_long() -> Example:
    """A row per speed and probe, tabs, velocity in mm/s rms as real and imaginary part, a row of units."""
    rows = ["Speed\tProbe\tRe\tIm", "Hz\t\tmm/s rms\tmm/s rms"]
    for speed, omega, values in zip(SPEED, OMEGA, VALUES):
        for name, value in zip("AB", 1j * omega * values * 1e3 / np.sqrt(2)):
            rows.append(f"{speed / 60:.14g}\t{name}\t{value.real:.14g}\t{value.imag:.14g}")
    settings = {"format": "csv", "columns": LONG, "probes": PLACES, "phase": "lead"}
    return Example("long.txt", ("\n".join(rows) + "\n").encode(), settings)


def excel() -> Example:
    import openpyxl

    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(["Run 7"])
    sheet.append(["N [1/min]", "A (µm pp)", "A deg", "B (µm pp)", "B deg"])
    for speed, (a, b) in zip(SPEED, VALUES):
        sheet.append([float(each) for each in (speed, abs(a) * 2e6, _lag(a), abs(b) * 2e6, _lag(b))])
    content = io.BytesIO()
    book.save(content)
    settings = {"format": "excel", "columns": WIDE, "probes": PLACES, "phase": "lag"}
    return Example("run.xlsx", content.getvalue(), settings)


def mat() -> Example:
    """A vector of speeds in rad/s and a matrix of acceleration in g zero to peak."""
    from scipy.io import savemat

    content = io.BytesIO()
    savemat(content, {"run": {"omega": OMEGA, "q": -(OMEGA[:, None] ** 2) * VALUES / 9.80665}}, do_compression=True)
    columns = ["speed=run.omega", "response.A=run.q[1]", "response.B=run.q[2]"]
    answers = {"unit": "g", "amplitude": "0pk", "phase": "lead", "speed_unit": "rad/s"}
    dated = content.getvalue()
    undated = b"MATLAB 5.0 MAT-file".ljust(116) + dated[116:]  # the same bytes at any time
    return Example("run.mat", undated, {"format": "mat", "columns": columns, "probes": PLACES, **answers})


def uff(binary: int = 0) -> Example:
    """Order functions over rpm: dataset 58 in text or binary."""
    import pyuff

    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "run.uff")
        file = pyuff.UFF(path)
        for number, name in enumerate("AB"):
            made = pyuff.prepare_58(
                binary=binary,
                func_type=0,
                rsp_ent_name=name,
                rsp_node=number + 1,
                rsp_dir=1,
                ref_ent_name="NONE",
                ref_node=1,
                ref_dir=1,
                abscissa_spacing=0,
                abscissa_spec_data_type=19,
                abscissa_axis_units_lab="rpm",
                ordinate_spec_data_type=8,
                ordinate_axis_units_lab="um",
                orddenom_spec_data_type=0,
                z_axis_spec_data_type=0,
                data=2e6 * VALUES[:, number],
                x=SPEED,
                id1=f"order 1 of {name}",
            )
            file.write_sets(made, "add")
        content = Path(path).read_bytes()
    settings = {"format": "uff", "probes": PLACES, "amplitude": "pp", "phase": "lead"}
    return Example("run.uff", content, settings, precision=1e-9)


def sampled(
    turns: int = 60, samples: int = 12_000, noise: float = 0.0, seed: int = 0
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Time (s), keyphasor (V), signals (n_sample, 2) µm and vectors (2, 2) µm of 1X and 2X in them.

    The speed rises evenly from 20 Hz to 24 Hz.
    """
    duration = turns / 22.0
    time = np.arange(samples) / samples * duration
    angle = 2 * np.pi * (20.0 * time + 2.0 * time**2 / duration)
    vectors = np.array([[12.0 * np.exp(0.7j), 3.0 * np.exp(-2.0j)], [8.0 * np.exp(-0.9j), 1.5 * np.exp(1.0j)]])
    signals = np.stack(
        [(first * np.exp(1j * angle) + second * np.exp(2j * angle)).real + 150.0 for first, second in vectors], axis=1
    )
    signals = signals + noise * np.random.default_rng(seed).standard_normal(signals.shape)
    turn = np.mod(angle / (2 * np.pi), 1.0)
    keyphasor = np.where(turn < 0.5, -5.0 * np.clip(1 - np.abs(turn - 0.02) / 0.02, 0, 1), 0.0)
    return time, keyphasor, signals, vectors


HALF_HEIGHT = 2 * np.pi * 0.01  # rad, where the keyphasor's pulse reaches half of its height


def waveform(noise: float = 0.0) -> Example:
    time, keyphasor, signals, _ = sampled(noise=noise)
    rows = ["time,KPH,A (um),B (um)"]
    rows += [f"{t:.9f},{k:.6g},{a:.9g},{b:.9g}" for t, k, (a, b) in zip(time, keyphasor, signals)]
    columns = ["time=time", "keyphasor=KPH", "signal.A=A (um)", "signal.B=B (um)"]
    settings = {"format": "waveform", "columns": columns, "probes": PLACES, "harmonics": [1.0, 2.0]}
    return Example("wave.csv", ("\n".join(rows) + "\n").encode(), settings)


TABLES = {
    "system1": system1,
    "adre": adre,
    "csv_wide": csv_wide,
    "csv_long": csv_long,
    "excel": excel,
    "mat": mat,
    "uff58": uff,
    "uff58b": lambda: uff(1),
}


def written(example: Example, **changes: Any) -> File:
    """The source of an example in the working directory, with other settings."""
    Path(example.name).write_bytes(example.content)
    return File(path=example.name, **{**example.settings, **changes})
