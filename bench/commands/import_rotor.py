"""`import rotor MODEL [--out rotor.yaml]`: a rotor model of another program as a rotor file.

Further arguments are [--unbalance 0.5] [--probe 1X@0.16] [--speeds 500:6000:200].

MODEL is a file of ROSS (TOML or JSON), or is left out for tables in CSV or Excel: `--shaft shaft.csv --disks disks.csv --bearing left.csv@0.08`,
also `--seal` and `--materials`; a sheet of a book is book.xlsx#sheet, and sheets of XLTRC2 are understood. Positions are in m (or @3.15in,
@station3), speeds in rpm. The shaft turns from x to y unless
`--rotation "y to x"` says otherwise. `--axes load` turns coefficients that were given with x along the load (down). What a model never
has (unbalance, probes, unknowns) is written as lines to be uncommented, or as given by options.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from bench.storage.files import replace_file
from ksmea.errors import SettingError, unknown, visible, visible_lines
from ksmea.measurement.channel import require_direction
from ksmea.units import RPM, SI_PER_UNIT
from problems.rotor.finite_elements.data import Rotor
from problems.rotor_document.description import ROTATIONS
from problems.rotor_file import RotorFile
from problems.rotor_import.axes import AXES, XY, in_own_axes
from problems.rotor_import.model import ImportedRotor, speeds_of_tables
from problems.rotor_import.ross import read_ross
from problems.rotor_import.tables import Place, Sheets, Station, read_sheets
from problems.rotor_import.tables_beside import with_tables_beside
from problems.rotor_import.yaml_text import Wanted, rotor_yaml

ROTOR = "rotor"
SEVERAL = ("probe", "unbalance", "bearing", "seal")
ONCE = ("shaft", "disks", "materials", "speeds", "rotation", "axes", "out")
TABLES = (".csv", ".xlsx", ".xlsm")
MOST_NAMES = 4  # of files written
MOST_PLACES = 8  # that the count lists of a kind
LENGTHS = SI_PER_UNIT["length"]
AT = re.compile(rf"station ?(?P<station>[0-9]{{1,6}})|(?P<number>[-+0-9.eE]+?) ?(?P<unit>{'|'.join(LENGTHS)})?")
NAMED = re.compile(r"\w*?([xXyY])[dD]?")  # the name of a probe that says its direction, 1X or 1XD


@dataclass
class _Asked:
    """Options and model on the command line."""

    model: str = ""
    once: dict[str, str] = field(default_factory=dict)
    several: dict[str, list[str]] = field(default_factory=lambda: {name: [] for name in SEVERAL})


def import_rotor(words: Sequence[str]) -> int:
    """Write the rotor file, and print the count to compare with the drawing."""
    try:
        asked = _asked(words)
        out = _out(asked)
        wanted = _wanted(asked)
        rotor = _read(asked)
        shown, tables = with_tables_beside(rotor, out.stem)
        texts = {out.name: rotor_yaml(shown, wanted), **tables}
        for name in texts:
            _require_new(out.with_name(name))
        built = _built(rotor, texts)
    except SettingError as error:
        raise SettingError(f"import rotor: {error}") from error
    out.parent.mkdir(parents=True, exist_ok=True)
    for name in reversed(texts):  # the tables that the rotor file names first
        replace_file(out.with_name(name), texts[name].encode())
    written = [str(out.with_name(name)) for name in texts]
    more = f" and {len(written) - MOST_NAMES} more" if len(written) > MOST_NAMES else ""
    lines = [f"written: {', '.join(written[:MOST_NAMES])}{more}", *_count(rotor, built), *_told(rotor, wanted)]
    lines.append(f"next: {shlex.join(['python', '-m', 'bench', 'draw', 'problem=rotor', f'problem.file={out}'])}")
    print(visible_lines("\n".join(lines)))
    return 0


def _require_new(path: Path) -> None:
    if path.exists():
        raise SettingError(f"expected no {path} yet, found one; choose another --out, or remove it")


def _out(asked: _Asked) -> Path:
    name = asked.once.get("out") or f"{Path(asked.model or asked.once['shaft'].partition('#')[0]).stem}.yaml"
    if Path(name).suffix not in (".yaml", ".yml"):
        raise SettingError(f"expected --out with the name of a YAML file, such as rotor.yaml, got {visible(name)}")
    if "#" in Path(name).name:
        raise SettingError(f"expected --out without #, which stands before the name of a sheet, got {visible(name)}")
    _require_new(Path(name))
    return Path(name)


def _read(asked: _Asked) -> ImportedRotor:
    """The model with what the options say of it."""
    rotor = read_ross(asked.model) if asked.model else read_sheets(_sheets(asked))
    rotation, axes = asked.once.get("rotation", ROTATIONS[0]), asked.once.get("axes", XY)
    if rotation not in ROTATIONS:
        raise unknown("--rotation", rotation, ROTATIONS)
    if axes not in AXES:
        raise unknown("--axes", axes, AXES)
    rotor = replace(rotor, rotation="" if rotation == ROTATIONS[0] else rotation)
    return in_own_axes(replace(rotor, speeds=rotor.speeds or speeds_of_tables(rotor)), axes)


def _built(rotor: ImportedRotor, texts: Mapping[str, str]) -> Rotor:
    """The rotor as the program reads it from files of these names, the first of which is the rotor file."""
    with TemporaryDirectory() as folder:
        for name, text in texts.items():
            (Path(folder) / name).write_bytes(text.encode())
        path = Path(folder) / next(iter(texts))
        try:
            return RotorFile(file=str(path)).build().rotor
        except SettingError as error:
            said = str(error).removeprefix(f"{path}: ")
            raise SettingError(f"{rotor.source}: in words of a rotor file, {said}") from error


def _count(rotor: ImportedRotor, built: Rotor) -> list[str]:
    """Count of parts, to be compared with the drawing."""
    n_element = sum(entry["elements"] for entry in rotor.shaft)
    n_layer = sum(len(entry.get("layers", ())) * entry["elements"] for entry in rotor.shaft)
    shaft = _counted(n_element, "element") + (f", {_counted(n_layer, 'layer')}" if n_layer else "")
    of_shaft = sum(segment.mass for segment in built.segments)
    supported = sum("support" in entry for entry in rotor.bearings)
    tabled = sum("table" in entry for entry in rotor.bearings)
    more = [f"{count} {what}" for count, what in ((tabled, "over speed"), (supported, "on supports")) if count]
    of_disks, of_masses = (sum(each.mass for each in parts) for parts in (built.disks, built.masses))
    lines = [
        "count, to compare with the drawing:",
        f"  shaft: {shaft}; {built.length:.5g} m; {of_shaft:.4g} kg",
        *_row("disks", rotor.disks, f"{of_disks:.4g} kg"),
        *_row("lumped masses", rotor.masses, f"{of_masses:.4g} kg"),
        *_row("couplings", rotor.couplings),
        *_row("bearings", rotor.bearings, ", ".join(more)),
        *_row("seals", rotor.seals),
    ]
    return [*lines, f"  in all: {built.mass:.4g} kg"]


def _row(name: str, entries: Sequence[dict[str, object]], more: str = "") -> list[str]:
    """`bearings: 2 at 0.08, 0.72 m; 1 over speed`."""
    if not entries:
        return []
    places = [f"{entry['position']:.4g}" for entry in entries]
    shown = ", ".join(places[:MOST_PLACES]) + (", …" if len(places) > MOST_PLACES else "")
    return [f"  {name}: {len(entries)} at {shown} m" + (f"; {more}" if more else "")]


def _counted(count: int, name: str) -> str:
    return f"{count} {name}" if count == 1 else f"{count} {name}s"


def _told(rotor: ImportedRotor, wanted: Wanted) -> list[str]:
    """Approximations, parts that are left out, and open questions."""
    lines = [f"note: {visible(remark)}" for remark in rotor.remarks]
    lines += [f"left out: {visible(each)}" for each in rotor.left_out]
    if wanted.speeds is None and rotor.speeds is None:
        lines.append("assumed: speeds; give --speeds FROM:TO:NUMBER (rpm). A measurement brings its own.")
    if not wanted.unbalance:
        lines.append(
            "open: unbalance and unknowns; give --unbalance POSITION (m), or uncomment them at the end of the file."
        )
    if not wanted.probes:
        lines.append("open: probes, for synthetic data; give --probe 1X@POSITION. A measurement brings its own.")
    return lines


def _asked(words: Sequence[str]) -> _Asked:
    asked = _Asked()
    remaining = iter(words)
    for word in remaining:
        if not word.startswith("--"):
            if asked.model:
                raise SettingError(f"expected one model, got {asked.model} and {word}")
            asked.model = word
            continue
        name, separator, value = word[2:].partition("=")
        if name not in (*SEVERAL, *ONCE):
            raise unknown("option", f"--{name}", [f"--{each}" for each in (*ONCE, *SEVERAL)])
        value = value if separator else next(remaining, "")
        if not value:
            raise SettingError(f"expected a value after --{name}, got nothing")
        if name in asked.once:
            raise SettingError(f"expected --{name} once, got it again; leave one out")
        if name in SEVERAL:
            asked.several[name].append(value)
        else:
            asked.once[name] = value
    if Path(asked.model).suffix.lower() in TABLES:
        raise SettingError(f"expected a file of ROSS (.toml, .json), got a table; give it as --shaft {asked.model}")
    tables: list[str] = [name for name in ("shaft", "disks", "materials") if name in asked.once]
    tables += [name for name in ("bearing", "seal") if asked.several[name]]
    if asked.model and tables:
        raise SettingError(f"expected a model or tables, got {asked.model} and --{tables[0]}")
    if not asked.model and "shaft" not in asked.once:
        raise SettingError("expected a file of ROSS (.toml, .json), or --shaft TABLE, got neither")
    return asked


def _sheets(asked: _Asked) -> Sheets:
    bearings, seals = (tuple(_at(word, name) for word in asked.several[name]) for name in ("bearing", "seal"))
    once = asked.once
    return Sheets(once["shaft"], once.get("disks", ""), once.get("materials", ""), bearings, seals)


def _at(word: str, option: str) -> tuple[str, Place]:
    """Text before the @, and a position (m) or the number of a station.

    The forms are `left.csv@0.08`, `left.csv@3.15in` and `left.csv@station3`.
    """
    file, separator, text = word.rpartition("@")
    place = AT.fullmatch(text)
    if not separator or not file or place is None:
        raise SettingError(f"--{option}: expected such as left.csv@0.08 (m), @3.15in or @station3, got {visible(word)}")
    if place["station"]:
        return file, Station(int(place["station"]))
    return file, _number(place["number"], option) * LENGTHS[place["unit"] or "m"]


def _number(text: str, option: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise SettingError(f"--{option}: expected a number, got {visible(text)}") from None


def _wanted(asked: _Asked) -> Wanted:
    unbalance = [_number(each, "unbalance") for each in asked.several["unbalance"]]
    speeds = _speeds(asked.once["speeds"]) if "speeds" in asked.once else None
    return Wanted(unbalance, [_probe(word) for word in asked.several["probe"]], speeds)


def _probe(word: str) -> tuple[float, str]:
    """Position (m) and direction of a probe.

    The forms are `x@0.16`, `45@0.16`, `1X@0.16`, or `left@0.16@45` as in the import of measurements.
    """
    first, *others = word.split("@")
    if not 1 <= len(others) <= 2:
        raise SettingError(f"--probe: expected such as 1X@0.16 (m) or left@0.16@45 (degrees from x), got {word}")
    named = NAMED.fullmatch(first)
    direction = others[1] if len(others) == 2 else named[1].lower() if named else first
    require_direction(direction, "--probe")
    return _number(others[0], "probe"), direction


def _speeds(text: str) -> tuple[float, float, int]:
    """`500:6000:200`: from and to in rpm, and their number."""
    parts = text.split(":")
    if len(parts) != 3 or not (parts[2].isascii() and parts[2].isdigit()):
        raise SettingError(f"--speeds: expected FROM:TO:NUMBER in rpm, such as 500:6000:200, got {visible(text)}")
    low, high = (_number(each, "speeds") for each in parts[:2])
    if not 0 < low < high < 1e6 / RPM:
        raise SettingError(f"--speeds: expected rpm that rise from above 0, got {visible(text)}")
    return low, high, int(parts[2][:9])  # the rotor file says how many may be
