"""Write the weight campaign of the RK-4 rig as a campaign of this project: all.csv and campaign.yaml.

Data: Zenodo 10.5281/zenodo.23152815, features as in M-Nouioua/rk4-rotor-unbalance-estimation.

    python docs/examples/rk4_weights.py features.csv rk4                          # all weights known
    python docs/examples/rk4_weights.py features.csv three --known BASE,A004,A012 # all others unknown
    python docs/examples/rk4_weights.py features.csv n1 --speed N1                # one of the two speeds

Amplitudes of the file are in mil, 0 to peak; its angles are lags, and its mounting angles run against the rotation: both change
their sign here. The disks stand at 0.16 and 0.4 m, the probes at 0.12 and 0.44 m.
"""

import argparse
import csv
import math
from pathlib import Path

MIL = 25.4  # µm
PLANES = {"U1": 0.16, "U2": 0.4}  # m
PROBES = {"plane1_x": (0.12, "x"), "plane1_y": (0.12, "y"), "plane2_x": (0.44, "x"), "plane2_y": (0.44, "y")}
HEADER = "speed_rpm,position_m,direction,amplitude_um_0pk,phase_lead_deg,time_s,run"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("features", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--known", default="", help="conditions whose weights are known, all if not given")
    parser.add_argument("--speed", default="", help="N1 or N2, both if not given")
    words = parser.parse_args()
    with words.features.open() as file:
        rows = [row for row in csv.DictReader(file) if words.speed in ("", row["speed_id"])]
    known = set(words.known.split(",")) if words.known else {row["condition_id"] for row in rows}
    begin = min(int(row["unix_time"]) for row in rows)
    words.folder.mkdir(parents=True, exist_ok=True)
    lines = [HEADER]
    for row in sorted(rows, key=lambda row: int(row["unix_time"])):
        for probe, (position, direction) in PROBES.items():
            size, lag = polar(row, f"{probe}_1x")
            cells = (row["rpm"], position, direction, f"{size * MIL:.6g}", f"{-lag:.6g}", int(row["unix_time"]) - begin)
            lines.append(",".join(map(str, (*cells, row["condition_id"]))))
    (words.folder / "all.csv").write_text("\n".join(lines) + "\n")
    conditions = {row["condition_id"]: row for row in rows}
    runs = [f"  - {{name: {name}, weights: {weights(row, name in known)}}}" for name, row in conditions.items()]
    (words.folder / "campaign.yaml").write_text("\n".join(["file: all.csv", "runs:", *runs]) + "\n")


def weights(row: dict[str, str], is_known: bool) -> str:
    """The weights of a condition in both planes, as YAML."""
    found = []
    for name, place in PLANES.items():
        size, angle = polar(row, name)
        if not is_known:
            found.append(f"{{position: {place}}}")
        elif size:
            found.append(f"{{position: {place}, g_mm: {size:.6g}, angle_deg: {-angle:.6g}}}")
    return f"[{', '.join(found)}]"


def polar(row: dict[str, str], name: str) -> tuple[float, float]:
    """Size and angle (deg) of a complex column."""
    value = complex(float(row[f"{name}_re"]), float(row[f"{name}_im"]))
    return abs(value), math.degrees(math.atan2(value.imag, value.real))


if __name__ == "__main__":
    main()
