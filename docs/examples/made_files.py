"""Make the files that docs/file_formats.md imports.

`python docs/examples/made_files.py MADE.CSV WIDE.CSV WAVE.CSV`.

MADE.CSV is a measurement of two probes, written by `python -m bench export measurement`. WIDE.CSV becomes the same data as a
wide table, peak to peak, with decimal commas and phase lags; WAVE.CSV a waveform with a keyphasor: 1X of 30 µm and 2X of 4 µm
with noise of 2 µm, while the speed rises from 20 to 36 Hz in 4 s.
"""

import sys

import numpy as np


def wide_table(made: str, path: str) -> None:
    """Write a measurement of two probes as a wide table in Windows-1252."""
    with open(made, encoding="utf-8") as file:
        rows = [line.split(",") for line in file if line[0].isdigit()]
    with open(path, "w", encoding="cp1252") as file:
        print("N [1/min];X (µm pp);X deg;Y (µm pp);Y deg", file=file)
        for x, y in zip(rows[::2], rows[1::2]):
            cells = [float(x[0]), 2 * float(x[3]), -float(x[4]), 2 * float(y[3]), -float(y[4])]
            print(";".join(f"{cell:.9g}".replace(".", ",") for cell in cells), file=file)


def waveform(path: str) -> None:
    """Write time in s, keyphasor in V and displacement in µm at 10 kHz."""
    t = np.arange(40000) / 10000
    turns = 20 * t + 2 * t**2
    wave = 30 * np.cos(2 * np.pi * turns + 0.5) + 4 * np.cos(4 * np.pi * turns)
    wave += np.random.default_rng(1).normal(0, 2, len(t))
    key = np.where(turns % 1 < 0.05, -6.0, -1.0)
    np.savetxt(path, np.stack([t, key, wave], axis=1), delimiter=",", header="t,KPH,A (um)", comments="", fmt="%.6f")


if __name__ == "__main__":
    wide_table(*sys.argv[1:3])
    waveform(sys.argv[3])
