"""Write bode_system1.csv: a run-up of the rotor of problem=three_disk as System 1 would export it.

Probes are at 45° left and right.

    python docs/examples/bode_system1.py > docs/examples/bode_system1.csv

3 % + 0.01 µm noise, slow-roll vectors of runout, a row that is not valid, values rounded as the instrument rounds them.
"""

import numpy as np

import ksmea

RUNOUT = {"45": 0.9 * np.exp(2.1j), "135": 0.6 * np.exp(-0.4j)}  # µm zero to peak
SLOW = np.array([300.0, 320.0, 340.0])  # rpm


def main() -> None:
    rotor = ksmea.load_problem("three_disk", directions=list(RUNOUT))
    data = ksmea.synthetic_measurement(rotor, relative=0.03, floor=0.01, kind="complex", rng=8).measurement
    rpm = np.concatenate([SLOW, data.speed * 30 / np.pi])
    for number, (name, side) in enumerate((("1YD", "Right"), ("1XD", "Left"))):
        runout = RUNOUT[data.channels[number].direction]
        vectors = runout + np.concatenate([np.zeros(len(SLOW)), data.values[:, number] * 1e6])
        for line in ("Machine Name,Three disks", f"Point Name,{name}", "Comp,", f"Probe Angle,45° {side}"):
            print(line)
        for line in ("X-Axis Unit,rpm", "Y-Axis Unit,µm pp", "Variable,1X"):
            print(line)
        print("X-Axis Value,Y-Axis Value,Y-Axis Status,Phase,Phase Status,Timestamp")
        for row, (speed, vector) in enumerate(zip(rpm, vectors)):
            status = "Invalid" if row == 7 else "Valid"
            lag = -np.angle(vector, deg=True) % 360
            clock = f"5/17/2024 9:{30 + row // 12:02d}:{5 * (row % 12):02d} AM"
            print(f"{speed:.0f},{2 * abs(vector):.3f},{status},{lag:.1f},{status},{clock}")


if __name__ == "__main__":
    main()
