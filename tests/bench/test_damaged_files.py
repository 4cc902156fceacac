"""Damaged rotors, extended problems, run-ups, campaigns, plans and records are read or refused in one visible line; `damaged_files`
says how to try many more."""

import csv
import re
import shutil
from pathlib import Path
from unittest.mock import patch

import openpyxl
import pytest
from hypothesis import event, given, settings

from bench import main as bench_main
from bench.reports import collect
from damaged_files import (
    FAULTS,
    cut,
    damaged,
    inserted,
    other_byte,
    other_cell,
    other_json,
    other_line,
    other_value,
    outcome_of,
    recoded,
    swapped,
    truncated,
)
from ksmea.errors import SettingError
from ksmea.problem.alignment import aligned
from measurements.campaign import CampaignFile
from measurements.file import File
from problems.extended_file import ExtendedFile
from problems.rotor_file import RotorFile
from problems.three_disk import ThreeDisk
from tiers import mostly_slow

EXAMPLES = Path(__file__).resolve().parents[2] / "docs" / "examples"
CAMPAIGN, RUNS = "campaign.yaml", "two_runs.csv"
# fmt: off
NUMBERS = [
    b"0", b"-1", b"1", b"1e308", b"1e-308", b"1e200", b"-0.0", b"1e400", b"1e-200", b"nan", b".inf", b"1000", b"100000",
    b"1000000000", b"99999999999999999999", b"010", b"1:30",
]
WORDS = [
    b"~", b"null", b"no", b"[]", b"{}", b"''", b"<<", b"*a", b"&a x", b"!!int 3", b'"\\e[31mred"', b'"a\\nb"', b"x" * 5000,
    b"[" * 200 + b"]" * 200, b"<<: {length: 3}", b"? [a]", "é".encode(), b"\x1b[2J", b"\x00", "\u202e".encode(), b"\t", b"- ",
]
JSON = [
    None, True, 0, -1, 1, 2, 10**9, 10**30, 1.5, 1e308, float("nan"), float("inf"), "", "x", "kxx", "summary", "done", "\x1b[2J",
    "a\nb", "x" * 5000, "../../up", [], [0], [[]], ["x", 1], {}, {"name": "x"}, {"a": {"b": []}},
]
KEYS = ["x", "name", "\x1b[2J", "bound"]
# fmt: on
YAML = (*[other_value(NUMBERS)] * 2, other_value(WORDS), other_byte, inserted(NUMBERS + WORDS), cut, other_line)
CELLS = [*NUMBERS, *WORDS, b"", b"1,5", b"1_000", b"kxx [N/mm]", b"[stone]", b"rpm"]
TABLE = (*[other_cell(CELLS)] * 3, other_byte, other_line, swapped, cut, recoded)
BYTES = (other_byte, other_byte, cut, truncated)
LINES = (*[other_json(JSON, KEYS)] * 4, other_byte)


def use(problem):
    """All that a program asks of a problem before it identifies it."""
    middle = (problem.parameters.lower + problem.parameters.upper) / 2
    problem.response(middle[None])
    if problem.has_sensitivity:
        problem.sensitivity(middle)


def use_file(settings):
    settings.reference(), settings.fingerprint()
    use(settings.build())


def use_run_up(folder):
    File(path=str(folder / "run_up.csv")).read()


def use_campaign(folder):
    source = CampaignFile(path=str(folder / CAMPAIGN), incomplete="drop")
    source.remarks, source.fingerprint()
    use(aligned(ThreeDisk().build(), source.read()))


def use_results(folder):
    """The commands on results, of a folder; figures are not drawn, which is most of the time of them."""
    refused = []
    exports = [["export", each, "--out", str(folder / each)] for each in ("ioh", "coco", "csv")]
    merge = ["merge", str(folder), "--out", str(folder / "merged")]
    with patch.object(collect, "_png", lambda chart: b""):
        for words in (["status"], ["explain", ""], ["collect"], *exports, merge):
            bench_main.run([*words, str(folder)], refused.append)
    if refused:
        raise SettingError("\n".join(refused[:1]))


TABLES = ("machine_sheet", "campaign_runs")  # in another form
TARGETS = {  # the file that is damaged, the slips, and what is done with its folder
    "rotor": ("rotor.yaml", YAML, lambda folder: use_file(RotorFile(file=str(folder / "rotor.yaml")))),
    "machine": ("machine.yaml", YAML, lambda folder: use_file(RotorFile(file=str(folder / "machine.yaml")))),
    "machine_table": ("bearing.csv", TABLE, lambda folder: use_file(RotorFile(file=str(folder / "machine.yaml")))),
    "machine_sheet": ("bearing.xlsx", BYTES, lambda folder: use_file(RotorFile(file=str(folder / "sheet.yaml")))),
    "extended": ("extended.yaml", YAML, lambda folder: use_file(ExtendedFile(file=str(folder / "extended.yaml")))),
    "run_up": ("run_up.csv", YAML, use_run_up),
    "campaign": (CAMPAIGN, YAML, use_campaign),
    "campaign_runs": (RUNS, YAML, use_campaign),
    "plan": ("plan.jsonl", LINES, use_results),
    "records": ("records/batch-0000.jsonl", LINES, use_results),
}


def without_remarks(path):
    """Most of an example are remarks, whose damage says nothing; what is optional stands in those of the campaign."""
    content = path.read_bytes()
    if path.name == CAMPAIGN:
        content = re.sub(rb"(?m)^( *)# (direction|speeds|own):", rb"\1\2:", content)
    return re.sub(rb"(?m)^ *#.*\n| +#.*$", b"", content) if path.suffix == ".yaml" else content


def with_sheet(folder):
    """The machine's table of its bearings as a sheet of a workbook."""
    book = openpyxl.Workbook()
    book.active.title = "bearing"
    for row in csv.reader((folder / "bearing.csv").read_text().splitlines()):
        book.active.append([float(cell) if cell[-1:].isdigit() else cell for cell in row])
    book.save(folder / "bearing.xlsx")
    content = (folder / "machine.yaml").read_text().replace("table: bearing.csv", "table: bearing.xlsx#bearing")
    (folder / "sheet.yaml").write_text(content)


@pytest.mark.parametrize("target", mostly_slow(TARGETS, but=[target for target in TARGETS if target not in TABLES]))
def test_damaged_files_are_read_or_refused_in_one_visible_line(target, table3, tmp_path):
    file, slips, attempt = TARGETS[target]
    folder = Path(shutil.copytree(table3.output, tmp_path / "table3"))
    for example in EXAMPLES.iterdir():
        if example.suffix in (".yaml", ".csv"):
            (folder / example.name).write_bytes(without_remarks(example))
    with_sheet(folder)
    examples = settings().max_examples
    if attempt is use_results:  # seven commands each
        examples //= 4

    @settings(max_examples=examples)
    @given(damaged((folder / file).read_bytes(), slips))
    def is_read_or_refused(content):
        def read():
            (folder / file).write_bytes(content)
            attempt(folder)

        outcome = outcome_of(read)
        event(outcome.ending)
        assert outcome.ending not in FAULTS, outcome.detail

    is_read_or_refused()
