"""Counts of verdicts on the evidence pages are those of results/reference."""

import csv
import re

import pytest
from scipy.stats import binomtest

from shown_pages import DOCS, ROOT, text_of

VISIBLE = 60.0  # deviance drop by the hidden effect
RATE = re.compile(r"(\d+) of (\d+) (?:visible draws )?\((\d+\.\d+) %, (\d+\.\d+)–(\d+\.\d+)\)")
PAGE = text_of(DOCS / "evidence_diagnosis.md")


def draws(name):
    with (ROOT / "results" / "reference" / f"{name}.runs.csv").open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def shown(row):
    """First numbers in the cells of a row of the page's table of verdicts, visible draws and others."""
    cells = re.search(rf"^\| {re.escape(row)} \| (\d+)[^|]* \| (\d+) \|$", PAGE, re.MULTILINE)
    return [int(cell) for cell in cells.groups()]


def test_verdicts_on_hidden_effects():
    counted = {row: [0, 0] for row in re.findall(r"^\| (`\w+`[^|]*) \|", PAGE, re.MULTILINE)}
    for draw in draws("diagnosis_effects"):
        verdict, is_right = draw["verdict"], draw["named"] == draw["hidden"]
        row = f"`{verdict}`"
        if verdict == "named":
            row += ", the hidden effect" if is_right else ", another one"
        if verdict == "ambiguous":
            row += ", with the hidden effect" if draw["in_group"] == "True" else ", without it"
        counted[row][float(draw["hidden_deviance_drop"]) < VISIBLE] += 1
    assert len(counted) == 6
    assert {row: shown(row) for row in counted} == counted


def test_false_alarms():
    wrong = [draw["verdict"] for draw in draws("diagnosis_nulls") if draw["verdict"] != "adequate"]
    counts = ", ".join(f"{wrong.count(each)} `{each}`" for each in ("unknown", "named", "ambiguous"))
    assert f"{len(wrong)} of {len(draws('diagnosis_nulls'))} " in PAGE
    assert counts in PAGE.replace("\n", " ")


@pytest.mark.parametrize(("count", "of", "rate", "low", "high"), RATE.findall(PAGE))
def test_rates_have_wilson_intervals(count, of, rate, low, high):
    found = binomtest(int(count), int(of)).proportion_ci(0.95, method="wilson")
    assert float(rate) == pytest.approx(100 * int(count) / int(of), abs=0.06)
    assert [float(low), float(high)] == pytest.approx([100 * found.low, 100 * found.high], abs=0.06)
