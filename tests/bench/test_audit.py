"""The audit: chances in closed form, verdicts by hand, and what it says of the paper's readings."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import norm

from bench.reports.accuracy import audit as auditing
from bench.reports.accuracy.audit import COLUMNS, TOGETHER, chance, chance_blind, joint_chance, rounding_pct, verdict
from bench.reports.accuracy.audit_page import HIGHEST, audit_chart
from bench.reports.tables import PAPER
from ksmea.show.charts.chart import Line, Points
from ksmea.show.charts.colours import INK


@pytest.fixture(scope="module")
def audited(apart, tmp_path_factory):
    """The audit as its users run it."""
    words = ["+experiment=audit", "workers=1"]
    return apart(*words, draws=True, cwd=tmp_path_factory.mktemp("audit"), output="results/audit")


@pytest.fixture(scope="module")
def frame(audited):
    assert audited.code == 0, audited.err
    return pd.read_csv(audited.output / "audit.csv", dtype={"column": str}, keep_default_na=False, na_values=["inf"])


def of(frame, **values):
    for column, value in values.items():
        frame = frame[frame[column] == value]
    assert len(frame)
    return frame


# -- by hand --


@pytest.mark.parametrize(("error", "expected"), [(0.0, 0.0), (2.0, 0.6826895), (4.0, 0.9544997), (3.9199280, 0.95)])
def test_the_chance_is_that_of_a_normal_error(error, expected):
    assert chance(error, 2.0) == pytest.approx(expected, abs=1e-6)


def test_where_the_data_say_nothing_there_is_no_chance():
    assert chance(50.0, np.inf) == 0


def test_the_blind_chance_is_a_share_of_the_search_interval():
    assert chance_blind(10, 50, 0, 100) == pytest.approx(0.1)  # 45 to 55
    assert chance_blind(100, 50, 10, 60) == pytest.approx(1.0)  # 0 to 100 holds it all
    assert chance_blind(10, 10, 10, 20) == pytest.approx(0.1)  # 10 to 11: the lower half is outside
    assert chance_blind(1, 5, 10, 20) == 0


@pytest.mark.parametrize(
    ("chance", "blind", "stuck", "expected"),
    [
        (0.9, 0.0, False, "possible"),
        (0.05, 0.0, False, "possible"),
        (0.0499, 0.0499, False, "lucky"),
        (0.001, 0.0, False, "lucky"),
        (0.000999, 0.0499, False, "impossible"),
        (0.0, 0.06, False, "possible"),
        (0.0, 0.0, True, "possible"),
    ],
)
def test_the_verdict(chance, blind, stuck, expected):
    assert verdict(chance, blind, stuck) == expected


@pytest.mark.parametrize(
    ("error", "value", "reference", "expected"),
    [
        ("3.6", "0.482", 0.5, 0.1),  # 0.0005 of 0.5, more than 0.05
        ("24", "0.38", 0.5, 1.0),  # 0.005 of 0.5, more than 0.5
        ("0.08", "50.04", 50, 0.01),
        ("0", "80", 80, 0.625),
        ("1", "50.5", 50, 0.5),
    ],
)
def test_the_rounding_is_half_the_last_digit_of_error_or_value(error, value, reference, expected):
    assert rounding_pct(error, value, reference) == pytest.approx(expected)


def test_independent_errors_have_the_product_of_their_chances():
    limits = np.array([0.5, 1.0, 2.0])
    expected = np.prod(2 * norm.cdf(limits) - 1)
    assert joint_chance(limits, np.eye(3)) == pytest.approx(expected, abs=4 * np.sqrt(0.25 / auditing.N_DRAW))


def test_errors_that_are_one_have_the_chance_of_the_smallest():
    limits = np.array([0.5, 1.0])
    correlation = np.array([[1.0, -1.0], [-1.0, 1.0]])
    assert joint_chance(limits, correlation) == pytest.approx(2 * norm.cdf(0.5) - 1, abs=4e-3)


# -- of the paper --


@pytest.mark.slow
def test_every_printed_error_has_a_row_in_every_reading(frame):
    assert list(frame) == list(COLUMNS)
    single = frame[frame["parameter"] != TOGETHER]
    for table, n_reading in (("table3", 8), ("table4", 8), ("table6", 8), ("table8", 2)):
        printed = pd.read_csv(PAPER / f"{table}.csv", dtype=str).dropna(subset="error_pct_printed")
        rows = of(single, table=table)
        assert len(rows.groupby(["reading", "damping", "kind"])) == n_reading
        for _, reading in rows.groupby(["reading", "damping", "kind"]):
            assert (
                reading["error_pct_printed"].astype(float).tolist()
                == printed["error_pct_printed"].astype(float).tolist()
            )
            assert reading["parameter"].tolist() == printed["parameter"].tolist()


# As shared/paper states them, 1 σ in per cent; they are of amplitudes without what the variance tells (1 %).
@pytest.mark.parametrize(
    ("reading", "damping", "expected"),
    [
        ("rad/s", "kN s/m", {"kxx": 0.11, "cxx": 8.6, "u": 0.99}),
        ("rpm", "kN s/m", {"kxx": 4145, "kyy": 4949, "u": 2159}),
        ("rad/s", "kN s/mm", {"kxx": 27, "cxx": 4.0, "cyy": 4.5}),
    ],
)
def test_the_readings_are_those_that_they_are_called(reading, damping, expected, frame):
    rows = of(frame, table="table3", reading=reading, damping=damping, kind="amplitude")
    for name, crlb in expected.items():
        assert of(rows, parameter=name)["crlb_pct"].astype(float).tolist() == pytest.approx([crlb] * 4, rel=0.05)


def test_k_is_impossible_in_rpm_and_everything_possible_in_rad_per_s(frame):
    amplitudes = of(frame, damping="kN s/m", kind="amplitude")
    for name in ("kxx", "kyy"):
        assert set(of(amplitudes, reading="rpm", parameter=name)["verdict"]) == {"impossible"}
    assert set(of(amplitudes, reading="rad/s")["verdict"]) == {"possible"}


def test_only_one_reading_allows_every_column_as_a_whole(frame):
    together = frame[(frame["parameter"] == TOGETHER) & (frame["table"] != "table8")]
    allowed = together.groupby(["reading", "damping", "kind"])["verdict"].agg(lambda found: set(found) == {"possible"})
    assert {place[:2] for place, is_allowed in allowed.items() if is_allowed} == {("rad/s", "kN s/m")}


def test_values_at_a_limit_of_the_search_and_slips_are_marked(frame):
    stuck = of(frame, reading="rad/s", kind="amplitude", at_search_limit=True)
    for damping in ("kN s/m", "kN s/mm"):  # the limits are read as the values are
        found = of(stuck, table="table3", damping=damping)
        assert [*zip(found["parameter"], found["column"])] == [("cxx", "40"), ("cyy", "40"), ("cyy", "200")]
    rows = of(frame, table="table3", reading="rpm", damping="kN s/m", kind="complex")
    slips = rows[rows["slip"] != ""]
    assert set(zip(slips["parameter"], slips["column"])) == {
        ("cyy", "40"),
        *((name, n) for name in ("kxx", "kyy", "cxx", "cyy", "u") for n in ("70", "100")),
    }


def test_a_printed_error_of_0_is_as_good_as_its_rounding(frame):
    u = of(frame, table="table8", parameter="u", kind="complex").iloc[0]
    assert float(u["chance"]) == pytest.approx(2 * norm.cdf(0.625 / float(u["crlb_pct"])) - 1, rel=1e-6)


def test_it_prints_a_line_per_table_and_reading(audited):
    lines = [line for line in audited.out.splitlines() if line.lstrip().startswith("table") and "/" in line]
    assert sum("kN s/" in line or "assumed" in line for line in lines) == 3 * 8 + 2
    assert "slip in print: table3, cyy, 40: 1 (98.6 %)" in audited.out
    assert (audited.output / "audit.png").read_bytes().startswith(b"\x89PNG")


def test_the_figure_holds_the_printed_errors_and_the_crlbs(frame):
    rows = of(frame, table="table3").astype({"error_pct_printed": str})
    numbers = ["error_pct_printed", "rounding_pct", "crlb_pct"]
    rows = rows.replace({"": np.nan}).assign(**{name: pd.to_numeric(rows[name], errors="coerce") for name in numbers})
    [panel] = audit_chart(rows.assign(slip=rows["slip"].fillna(""))).panels
    dots = sorted(
        value for each in panel.elements if isinstance(each, Points) and each.colour == INK for value in each.y
    )
    printed = pd.read_csv(PAPER / "table3.csv")["error_pct_printed"].dropna()
    assert dots == pytest.approx(sorted(printed))
    drawn = {round(y, 6) for each in panel.elements if isinstance(each, Line) for y in each.y if np.isfinite(y)}
    crlbs = rows["crlb_pct"].dropna()
    assert drawn == {round(crlb, 6) for crlb in crlbs if crlb < HIGHEST}
    (marked,) = [each for each in panel.elements if each.name == "printed, at a search limit, with a slip"]
    stuck = rows[(rows["slip"].fillna("") != "") & rows["at_search_limit"]].drop_duplicates(["parameter", "column"])
    assert marked.is_open and marked.symbol == "square" and list(marked.y) == stuck["error_pct_printed"].tolist()
