"""`draw problem=NAME [OPTION=…] [output=DIR]`: a rotor to scale and its whirl.

Further arguments are [problem.SETTING=…] and [values.UNKNOWN=…].

Figures, the numbers behind them as CSV files, and one page with all of it.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from bench.command_line.messages import USER_ERRORS, in_our_words
from bench.command_line.overrides import parse, with_quoted_files
from bench.command_line.plugin_words import PLUGINS, register_plugins
from bench.plan.folder import folder_part
from bench.plan.page import Block, Command, Drawn, Page, Prose, Section, Table
from bench.plan.plan import PLAN_FILE
from bench.reports.pages.document import document
from bench.reports.pages.index import PAGE, page_facts, write_index_above
from bench.reports.pages.made_by import command_line
from bench.reports.tables import csv_text
from bench.storage.files import replace_file
from ksmea.errors import SettingError, unknown, visible_lines
from ksmea.loaded_problem import load_problem
from ksmea.rotor_drawing import RotorDrawing
from ksmea.rotordynamics.margins import CLAUSE
from ksmea.rotordynamics.whirl import Rotordynamics
from ksmea.settings.settings import own_fields
from ksmea.show.charts.mode_shape_charts import deflections_chart, orbits_chart
from ksmea.show.charts.picture import png
from ksmea.show.charts.rotor_chart import rotor_chart
from ksmea.show.charts.whirl_charts import campbell_chart, speed_map_chart, stability_chart
from ksmea.show.margins_text import margin_table
from ksmea.show.rotordynamics_text import FRAMES, bearing_table, critical_speed_table, mode_table, sentences
from ksmea.studies.rotordynamics import RotordynamicsOptions
from ksmea.units import RPM

PROBLEM, VALUES, OUTPUT = "problem", "values", "output"
DEFAULT = "three_disk"
STUDY = "draw"  # what an index calls it
WHEN = "%Y-%m-%dT%H:%M:%S%z"  # of which an index shows the first part, as of records
OPTIONS = tuple(field.name for field in own_fields(RotordynamicsOptions))


def draw(words: list[str]) -> int:
    """Write the files into the folder, and print the critical speeds."""
    name, settings, values, options, output = _asked(with_quoted_files(words))
    folder = Path(output) if output else Path("results") / _folder_name(name, settings)
    if (folder / PLAN_FILE).exists():
        raise SettingError(
            f"{folder}: expected a folder of its own, got one of an experiment; choose another output=DIR"
        )
    _require_own_page(folder / PAGE)
    loaded = load_problem(name, **settings)
    drawing = loaded.draw(values, **options)
    record = drawing.record
    is_there = {
        "speed_map": record.speed_map is not None,
        "margins": record.operating is not None,
        "sag": record.layout.sag is not None,
    }
    left_out = [name for name, there in is_there.items() if not there]
    sections = rotor_sections(drawing.record)
    files = {name: png(describe()) for name, describe in Page(sections=sections).charts().items()}
    n_picture = len(files)
    files |= {f"{each}.csv": csv_text(drawing.to_frame(each)).encode() for each in FRAMES if each not in left_out}
    file = settings.get("file")
    title = f"{drawing.record.title}: {Path(str(file)).name}" if file else drawing.record.title
    files[PAGE] = _page(drawing, sections, title, words, files)
    folder.mkdir(parents=True, exist_ok=True)
    for each in left_out:  # of an earlier drawing
        for suffix in ("png", "csv"):
            (folder / f"{each}.{suffix}").unlink(missing_ok=True)
    for file, content in files.items():
        replace_file(folder / file, content)
    write_index_above(folder)
    print(visible_lines(f"{drawing}\nwritten: {folder / PAGE}, {n_picture} figures (.png) and their numbers (.csv)"))
    return 0


def _require_own_page(page: Path) -> None:
    """Raise `SettingError` if a page stands that is not one of a drawing, which would be lost."""
    if page.exists() and page_facts(page.parent).get("study") != STUDY:
        raise SettingError(f"{page}: expected a drawing's page or none, found another page; choose another output=DIR")


def _page(
    drawing: RotorDrawing, sections: Sequence[Section], title: str, words: list[str], files: Mapping[str, bytes]
) -> bytes:
    """The page with all of it, and what an index of results tells of it."""
    found = drawing.record
    n_at_1x = sum(each.harmonic == 1 for each in found.critical_speeds)
    headline = f"{n_at_1x} critical speed{'s' * (n_at_1x != 1)} up to {found.highest / RPM:.0f} rpm"
    made_by = Section("Made by", (Command(command_line(["draw", *words])),))
    about = {"name": title, "study": STUDY, "when": time.strftime(WHEN), "headline": headline}
    return document(title, Page(headline), [*sections, made_by], about, files)


def rotor_sections(found: Rotordynamics) -> tuple[Section, ...]:
    """The chapters of the page. Figures are named as the files next to it."""
    size, *others = sentences(found)
    rotor: tuple[Block, ...] = (
        Prose("\n".join(others)),
        Drawn(rotor_chart(found.layout, size.rstrip(".")), "rotor.png"),
        Table(bearing_table(found), "Bearings"),
    )
    whirl: list[Block] = [
        Drawn(campbell_chart(found), "campbell.png"),
        Table(critical_speed_table(found), "Critical speeds", "critical_speeds.csv"),
    ]
    if found.operating is not None:
        whirl.append(Table(margin_table(found), f"Separation margins ({CLAUSE})", "margins.csv"))
    modes = (
        Table(mode_table(found), "Modes"),
        *((Drawn(orbits_chart(found), "orbits.png"),) if found.shapes.directions else ()),
        Drawn(deflections_chart(found), "deflections.png"),
    )
    sections = [
        Section("Rotor", rotor),
        Section("Critical speeds", tuple(whirl)),
        Section("Stability", (Drawn(stability_chart(found), "stability.png"),)),
    ]
    if found.speed_map is not None:
        sections.append(Section("Stiffness of the bearings", (Drawn(speed_map_chart(found), "speed_map.png"),)))
    return (*sections, Section("Mode shapes", modes))


def _asked(words: list[str]) -> tuple[str, dict[str, Any], dict[str, float], dict[str, Any], str | None]:
    """Problem, its settings, values of unknowns, options of the drawing, and the folder."""
    for word in words:
        if "=" not in word or word.startswith("-"):
            raise SettingError(f"draw: expected setting=value, got {word}; as in draw problem={DEFAULT} output=DIR")
    register_plugins(words)
    given: dict[str, Any] = {}
    try:
        choices = parse(words)
    except USER_ERRORS as error:
        raise in_our_words(error) from error
    for choice in choices:
        if len(choice.values) != 1 or choice.override.is_sweep_override():
            raise SettingError(
                f"draw: expected one value of {choice.key}, got {len(choice.values)}; draw one after the other"
            )
        _put(given, choice.key.split("."), choice.values[0])
    given.pop(PLUGINS, None)
    problem, values, output = given.pop(PROBLEM, {}), given.pop(VALUES, {}), given.pop(OUTPUT, None)
    settings = dict(problem)
    for key in given:
        if key not in OPTIONS:
            raise unknown("setting of draw:", key, [PROBLEM, VALUES, OUTPUT, *OPTIONS])
    if not isinstance(values, Mapping):
        raise SettingError(f"values: expected values by name, as values.kxx=50, got {values}")
    for name, value in values.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise SettingError(f"values.{name}: expected a number in the unit of the unknown, got {value}")
    return str(settings.pop("name", DEFAULT)), settings, dict(values), given, None if output is None else str(output)


def _put(given: dict[str, Any], keys: list[str], value: Any) -> None:
    """A value into nested settings; a mapping is added to what is there.

    The name of a plugin stands next to its settings.
    """
    first, *rest = keys
    inner = given.get(first, {})
    if not rest and not isinstance(value, Mapping) and first != PROBLEM:
        given[first] = value
        return
    inner = dict(inner) if isinstance(inner, Mapping) else {"name": inner}
    if rest:
        _put(inner, rest, value)
    else:
        inner |= value if isinstance(value, Mapping) else {"name": value}
    given[first] = inner


def _folder_name(name: str, settings: Mapping[str, Any]) -> str:
    file = settings.get("file")
    stem = folder_part(Path(file).stem) if isinstance(file, str) else ""
    return f"draw_{stem or name}"
