"""`compare NAME|DIR NAME|DIR [--out DIR]`: two identifications or diagnoses side by side.

The comparison is a text, `compare.csv` and a page.
"""
# Shorter than 40 lines: one command a file.

from __future__ import annotations

from pathlib import Path

from bench.commands.folders import one_folder, with_option
from bench.reports.comparison.comparison import compared, text
from bench.reports.comparison.page import comparison_page
from bench.reports.comparison.sides import n_with_result, read_side
from bench.reports.pages.experiment import PAGE
from bench.reports.tables import csv_text
from bench.storage.files import replace_file
from ksmea.errors import SettingError, visible, visible_lines

TABLE = "compare.csv"


def compare(words: list[str]) -> int:
    """Print what both say, and write the table and the page."""
    names, out = with_option(words, "--out", "compare")
    if len(names) != 2:
        raise SettingError(f"compare: expected two names or folders of results, got {len(names)}")
    places = [one_folder([name], "compare") for name in names]
    sides = [read_side(place) for place in places]
    found = compared(sides[0], sides[1])
    print(visible_lines(text(found)))
    for place, side in zip(places, sides):
        if (n := n_with_result(side.plan, place)) > 1:
            print(visible(f"note: {place} has {n} runs with a result; the first is compared"))
    output = Path(out) if out else Path("results") / f"compare_{places[0].name}_{places[1].name}"
    output.mkdir(parents=True, exist_ok=True)
    replace_file(output / TABLE, csv_text(found.unknowns).encode())
    replace_file(output / PAGE, comparison_page(found))
    print(f"\n{visible(f'in {output}: {TABLE}, {PAGE}')}")
    return 0
