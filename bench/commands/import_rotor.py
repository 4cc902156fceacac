"""`import rotor MODEL [--probe x@0.16] [--unbalance 0.5] [--speeds 500:6000:200] [--out rotor.yaml]`: a rotor model of another program as
a rotor file.

MODEL is a file of ROSS (TOML or JSON), or is left out for tables: `--shaft shaft.csv --disks disks.csv --bearing left.csv@0.08`. Positions
are in m, speeds in rpm. What a model never has (unbalance, probes, unknowns) is written as lines to be uncommented, or as asked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from bench.storage.files import replace_file
from ksmea.errors import SettingError, unknown, visible, visible_lines
from ksmea.measurement.channel import require_direction
from ksmea.units import RPM
from problems.rotor_file import RotorFile
from problems.rotor_import.model import ImportedRotor
from problems.rotor_import.ross import read_ross
from problems.rotor_import.tables import Sheets, read_sheets
from problems.rotor_import.yaml_text import Wanted, rotor_yaml

ROTOR = "rotor"
SEVERAL = ("probe", "unbalance", "bearing", "seal")
ONCE = ("shaft", "disks", "materials", "speeds", "out")


@dataclass
class _Asked:
    """What words ask for."""

    model: str = ""
    once: dict[str, str] = field(default_factory=dict)
    several: dict[str, list[str]] = field(default_factory=lambda: {name: [] for name in SEVERAL})


def import_rotor(words: Sequence[str]) -> int:
    """Write the rotor file, and print the count to compare with the drawing."""
    asked = _asked(words)
    out = Path(asked.once.get("out") or f"{Path(asked.model or asked.once['shaft'].partition('#')[0]).stem}.yaml")
    if out.exists():
        raise SettingError(f"import rotor: expected no {out} yet, found one; choose another --out, or remove it")
    rotor = read_ross(asked.model) if asked.model else read_sheets(_sheets(asked))
    wanted = _wanted(asked)
    content = rotor_yaml(rotor, wanted).encode()
    out.parent.mkdir(parents=True, exist_ok=True)
    replace_file(out, content)
    try:
        built = RotorFile(file=str(out)).build().rotor
    except SettingError:
        out.unlink()  # nothing stays that is no rotor
        raise
    print(visible_lines("\n".join([f"written: {out}", *_count(rotor, built.mass, built.length, wanted, out)])))
    return 0


def _count(rotor: ImportedRotor, mass: float, length: float, wanted: Wanted, out: Path) -> list[str]:
    """What there is, to be compared with the drawing, and what comes next."""
    n_element = sum(entry["elements"] for entry in rotor.shaft)
    n_layer = sum(len(entry.get("layers", ())) * entry["elements"] for entry in rotor.shaft)
    supports = sum("support" in entry for entry in rotor.bearings)
    counts = (
        (n_element, "element"), (n_layer, "layer"), (len(rotor.disks), "disk"), (len(rotor.masses), "lumped mass"),
        (len(rotor.bearings), "bearing"), (len(rotor.seals), "seal"), (supports, "support"),
    )  # fmt: skip
    parts = ", ".join(f"{count} {_plural(name, count)}" for count, name in counts if count)
    lines = [f"  {parts}; {mass:.4g} kg, {length:.5g} m. Compare with the drawing."]
    lines += [f"  {visible(remark)}" for remark in rotor.remarks]
    lines += [f"  left out: {visible(each)}" for each in rotor.left_out]
    if not wanted.unbalance:
        lines.append(
            "  To compare it with data, uncomment unbalance and unknowns in it, or give --unbalance POSITION (m)."
        )
    return [*lines, f"next: python -m bench draw problem=rotor problem.file={out}"]


def _plural(name: str, count: int) -> str:
    return name if count == 1 else f"{name}es" if name.endswith("s") else f"{name}s"


def _asked(words: Sequence[str]) -> _Asked:
    asked = _Asked()
    remaining = iter(words)
    for word in remaining:
        if not word.startswith("--"):
            if asked.model:
                raise SettingError(f"import rotor: expected one model, got {asked.model} and {word}")
            asked.model = word
            continue
        name, separator, value = word[2:].partition("=")
        if name not in (*SEVERAL, *ONCE):
            raise unknown("option of import rotor:", f"--{name}", [f"--{each}" for each in (*ONCE, *SEVERAL)])
        value = value if separator else next(remaining, "")
        if not value:
            raise SettingError(f"import rotor: expected a value after --{name}, got nothing")
        if name in SEVERAL:
            asked.several[name].append(value)
        else:
            asked.once[name] = value
    tables: list[str] = [name for name in ("shaft", "disks", "materials") if name in asked.once]
    tables += [name for name in ("bearing", "seal") if asked.several[name]]
    if asked.model and tables:
        raise SettingError(f"import rotor: expected a model or tables, got {asked.model} and --{tables[0]}")
    if not asked.model and "shaft" not in asked.once:
        raise SettingError("import rotor: expected a file of ROSS (.toml, .json), or --shaft TABLE, got neither")
    return asked


def _sheets(asked: _Asked) -> Sheets:
    bearings, seals = (tuple(_at(word, name) for word in asked.several[name]) for name in ("bearing", "seal"))
    once = asked.once
    return Sheets(once["shaft"], once.get("disks", ""), once.get("materials", ""), bearings, seals)


def _at(word: str, option: str) -> tuple[str, float]:
    """`left.csv@0.08`: what comes before, and a position, m."""
    first, separator, place = word.rpartition("@")
    if not separator or not first:
        raise SettingError(f"import rotor: --{option}: expected such as left.csv@0.08 (m), got {word}")
    return first, _number(place, option)


def _number(text: str, option: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise SettingError(f"import rotor: --{option}: expected a number, got {visible(text)}") from None


def _wanted(asked: _Asked) -> Wanted:
    probes = []
    for word in asked.several["probe"]:
        direction, _, place = word.partition("@")
        require_direction(direction, "import rotor: --probe")
        probes.append((_number(place, "probe"), direction))
    unbalance = [_number(each, "unbalance") for each in asked.several["unbalance"]]
    return Wanted(unbalance, probes, _speeds(asked.once["speeds"]) if "speeds" in asked.once else None)


def _speeds(text: str) -> tuple[float, float, int]:
    """`500:6000:200`: from and to in rpm, and their number."""
    parts = text.split(":")
    if len(parts) != 3 or not parts[2].isdigit():
        raise SettingError(
            f"import rotor: --speeds: expected FROM:TO:NUMBER in rpm, such as 500:6000:200, got {visible(text)}"
        )
    low, high = (_number(each, "speeds") for each in parts[:2])
    if not 0 < low < high < 1e7 / RPM:
        raise SettingError(f"import rotor: --speeds: expected rpm that rise from above 0, got {visible(text)}")
    return low, high, int(parts[2])
