"""The report of a contest: what is compared, what counts as not reached, and what its tables, figures and page say."""

import dataclasses
import json

import numpy as np
import pandas as pd
import pytest

from bench.jobs.lines import SCHEMA
from bench.jobs.records import finished_keys, record_file
from bench.plan.plan import all_runs
from bench.reports.collect import collect
from bench.reports.contest.charts import ecdf_chart, solved_chart
from bench.reports.contest.comparisons import all_pairs_frame, friedman_frame
from bench.reports.contest.ecdf_curves import anytime_frame, ecdf_frame, profiles_frame
from bench.reports.contest.entrants import entrants_frame
from bench.reports.contest.leaderboard import leaderboard, running_time_frame
from bench.reports.contest.ranks import resamples
from bench.reports.contest.report import ContestReport
from bench.reports.contest.runs import contest
from bench.reports.contest.words import sentences
from bench.reports.identification.trace_table import read_traces
from bench.reports.runs import runs_frame
from contests import FAILED, contest_plan, record, write_contest
from ksmea.errors import SettingError
from ksmea.show.charts.chart import Band, Line, Points, Words
from ksmea.show.charts.picture import figure

METHODS = ("fast", "slow")
INSTANCES = [("one_disk", 3), ("one_disk", 3), ("two_disk", 4)]


def falls(d, speed, **further):
    """A run whose excess falls tenfold with each so many evaluations."""
    evaluations = range(1, 100)
    return record(d, evaluations, [1e4 * 10 ** (-number / speed) for number in evaluations], **further)


def usual(label, instance, repetition):
    """The fast one reaches an excess of 1 after 20 and more evaluations, the slow one after 60 and more."""
    d = INSTANCES[instance][1]
    return falls(d, {"fast": 5.0, "slow": 15.0}[label] + 0.1 * instance + 0.03 * repetition)


@pytest.fixture
def found(tmp_path):
    """The contest of a plan whose runs have these results."""

    def call(result=usual, plan=None):
        made = contest_plan(METHODS, INSTANCES) if plan is None else plan
        write_contest(made, tmp_path, result)
        return contest(made, runs_frame(made, tmp_path), read_traces(made, tmp_path))

    return call


def weights(compared, n=50):
    return resamples(compared.families.tolist(), np.random.default_rng(3), n)


def test_all_runs_of_all_methods_are_compared(found):
    compared = found()
    assert compared.methods == METHODS and compared.notes == ()
    assert compared.instances["family"].tolist() == ["one_disk", "one_disk", "two_disk"]
    assert compared.instances["number"].tolist() == [1, 2, 1] and compared.instances["unknowns"].tolist() == [3, 3, 4]
    assert list(compared.groups()) == ["all", "one_disk", "two_disk"]
    assert len(compared.runs) == 2 * 3 * 2 and (compared.runs["cost"] == 100).all()
    first = compared.runs.query("method == 0 and instance == 0 and repetition == 0").index[0]
    assert compared.hits["excess"][first].tolist() == [5, 8, 10, 13, 15, 18, 20, 23, 25]  # 5 log10(1e4 / target), up


def test_the_leaderboard_says_who_is_first_and_at_what_cost(found):
    compared = found()
    board = leaderboard(compared, weights(compared))
    assert board["family"].tolist() == ["all", "all", "one_disk", "one_disk", "two_disk", "two_disk"]
    rows = board[board["family"] == "all"].set_index("method")
    assert rows["speed_rank"].to_dict() == {"fast": 1.0, "slow": 2.0} and rows.loc["fast", "speed_first"] == 1.0
    assert rows["excess_rank"].to_dict() == {"fast": 1.5, "slow": 1.5}  # in the end the data cannot tell them apart
    assert rows["excess_reached"].tolist() == [1.0, 1.0] and rows["failed"].tolist() == [0, 0]
    hits = compared.hits["excess"][compared.runs["method"] == 0, 6]  # of an excess of 1
    assert rows.loc["fast", "excess_ert"] == pytest.approx(hits.mean())
    assert rows.loc["fast", "excess_ert_low"] <= rows.loc["fast", "excess_ert"] <= rows.loc["fast", "excess_ert_high"]


def test_a_failed_run_is_charged_its_budget_and_reaches_nothing(found):
    def result(label, instance, repetition):
        return FAILED if (label, instance, repetition) == ("fast", 0, 0) else usual(label, instance, repetition)

    compared, without = found(result), found()
    board = leaderboard(compared, weights(compared)).query("family == 'all' and method == 'fast'").iloc[0]
    assert board["failed"] == 1 and board["runs"] == 6 and board["excess_reached"] == pytest.approx(5 / 6)
    hits = without.hits["excess"][without.runs["method"] == 0, 6]
    assert board["excess_ert"] == pytest.approx((100 + hits.sum() - 20) / 5)
    assert any("failed, counted as never reaching a target: fast 1" in each for each in told(compared))


def test_a_run_that_ends_early_is_censored_at_its_end(found):
    def result(label, instance, repetition):
        if label == "slow":
            return record(INSTANCES[instance][1], [1, 40], [500.0, 50.0], took=40, status="done")
        return usual(label, instance, repetition)

    compared = found(result)
    times = running_time_frame(compared, weights(compared)).query("family == 'all' and method == 'slow'")
    excess = times[times["measure"] == "excess"].set_index("target")
    assert excess.loc[1000.0, "ert"] == 1 and excess.loc[100.0, "ert"] == 40
    assert excess.loc[30.0, "ert"] == np.inf and excess.loc[30.0, "reached"] == 0
    curve = ecdf_frame(compared, weights(compared)).query(
        "family == 'all' and method == 'slow' and measure == 'excess'"
    )
    assert curve["share"].iloc[-1] == pytest.approx(3 / 9)  # 1000, 300 and 100 of nine targets, for ever
    had = anytime_frame(compared).query("family == 'two_disk' and method == 'slow'")
    assert had["excess_median"].iloc[[0, -1]].tolist() == [500.0, 50.0]


def test_a_run_without_a_trace_reaches_nothing_but_has_not_failed(found):
    def result(label, instance, repetition):
        made = usual(label, instance, repetition)
        return made | {"trace": None} if label == "slow" else made

    compared = found(result)
    rows = leaderboard(compared, weights(compared)).query("family == 'all'").set_index("method")
    assert rows.loc["slow", "failed"] == 0 and rows.loc["slow", "excess_reached"] == 0
    assert rows.loc["slow", "excess_rank"] == 2.0 and rows.loc["slow", "excess_ert"] == np.inf


def test_the_order_of_runs_and_records_changes_nothing(found, tmp_path):
    def result(label, instance, repetition):
        return FAILED if (label, instance, repetition) == ("slow", 1, 0) else usual(label, instance, repetition)

    compared = found(result)
    turned = compared.runs.index[::-1]
    other = dataclasses.replace(
        compared,
        runs=compared.runs.loc[turned].reset_index(drop=True),
        hits={name: each[turned] for name, each in compared.hits.items()},
        overheads={name: each[turned] for name, each in compared.overheads.items()},
    )
    drawn = weights(compared)
    for make in (leaderboard, running_time_frame, ecdf_frame, friedman_frame):
        pd.testing.assert_frame_equal(make(compared, drawn), make(other, drawn))
    for make in (anytime_frame, profiles_frame, all_pairs_frame):
        pd.testing.assert_frame_equal(make(compared), make(other))


def test_a_newcomer_is_compared_on_what_all_have_ended(found):
    def result(label, instance, repetition):
        if label == "slow" and (instance == 2 or (instance, repetition) == (0, 1)):
            return None
        return usual(label, instance, repetition)

    compared = found(result)
    assert compared.families.tolist() == ["one_disk", "one_disk"]
    places = compared.runs[["method", "instance", "draw"]].value_counts()
    assert len(places) == 2 * 3 and (places == 1).all()  # of the first instance one draw, of the second both
    assert compared.notes == (
        "compared on the 2 of 3 instances and 3 of 6 draws that all methods have ended; not ended: slow 3",
    )


def test_a_run_that_was_begun_and_has_no_end_is_no_failure(tmp_path):
    """It was interrupted, or is being done: its draw is left out until it has ended."""
    plan = contest_plan(METHODS, INSTANCES)
    write_contest(plan, tmp_path, lambda label, *at: None if (label, *at) == ("slow", 2, 1) else usual(label, *at))
    [key] = {run.key for run in plan.runs} - finished_keys(tmp_path, plan)
    path = record_file(tmp_path, 0)
    session = json.loads(path.read_text().splitlines()[0])["session"]
    line = {"schema": SCHEMA, "event": "started", "key": key, "question": "", "session": session}
    path.write_text(path.read_text() + json.dumps(line) + "\n")
    made = ContestReport().make(plan, tmp_path)
    assert "0 failed" in made.text and "5 of 6 draws that all methods have ended; not ended: slow 1" in made.text
    assert made.runs.set_index("key").loc[key, "status"] == "interrupted"


def test_a_method_without_any_run_takes_no_part(found):
    compared = found(lambda label, *place: None if label == "slow" else usual(label, *place))
    assert compared.methods == ("fast",) and compared.notes == ("slow: no run has ended; left out",)
    rows = leaderboard(compared, weights(compared))
    assert (rows["excess_rank"] == 1.0).all()
    assert (
        told(compared)[0]
        == "one method alone, fast: nothing to rank; merge its folder with others (docs/merge_export.md)"
    )


def test_cells_of_a_label_that_differ_otherwise_are_refused():
    plan = contest_plan(METHODS, INSTANCES)
    twice = dataclasses.replace(plan.cells[0], settings={**plan.cells[0].settings, "samples": 40})
    cells = (*plan.cells, twice)
    plan = dataclasses.replace(plan, cells=cells, runs=all_runs(cells, 1, {}))
    with pytest.raises(SettingError, match="expected one cell of label fast for each instance"):
        contest(plan, pd.DataFrame(), {})


def test_budgets_that_differ_are_told(found):
    plan = contest_plan(METHODS, INSTANCES)
    study = {**plan.cells[0].settings["study"], "budget": 1000}
    more = dataclasses.replace(plan.cells[0], settings={**plan.cells[0].settings, "study": study})
    compared = found(plan=dataclasses.replace(plan, cells=(more, *plan.cells[1:])))
    assert compared.notes == ("budgets differ between methods: results at the end are not at equal cost",)


def test_what_nobody_knows_the_excess_of_is_ranked_by_its_error(found):
    def result(label, instance, repetition):
        made = usual(label, instance, repetition)
        return made | {"trace": made["trace"] | {"least": None}}

    compared = found(result)
    assert [measure.name for measure in compared.measures] == ["error"]
    board = leaderboard(compared, weights(compared))
    assert "excess_rank" not in board and board.loc[0, "method"] == "fast"


def test_a_surrogate_pays_from_the_price_at_which_totals_are_alike(found):
    """Reached after 20 and 60 evaluations of 100, in 2 s and 0.6 s of which the model has a tenth: 1.8 s more for 40 less."""

    def result(label, instance, repetition):
        speed, seconds, surrogate = {"fast": (5.0, 10.0, 500), "slow": (15.0, 1.0, 0)}[label]
        return falls(INSTANCES[instance][1], speed, seconds=seconds, surrogate=surrogate)

    compared = found(result)
    rows = leaderboard(compared, weights(compared)).query("family == 'all'").set_index("method")
    assert rows["overhead_s"].to_dict() == pytest.approx({"fast": 1.8, "slow": 0.54})
    assert rows.loc["fast", "break_even_s"] == pytest.approx((1.8 - 0.54) / 40)
    assert np.isnan(rows.loc["slow", "break_even_s"])


def told(compared):
    drawn = weights(compared)
    board = leaderboard(compared, drawn)
    return sentences(compared, board, all_pairs_frame(compared), friedman_frame(compared, drawn))


@pytest.mark.parametrize(
    "held_back, expected",
    [
        ((False, False, False), "open set (3 open, 0 held back): the final ranking uses the held-back set only"),
        ((True, False, True), "open set (1 open, 2 held back): the final ranking uses the held-back set only"),
        ((True, True, True), "all instances are of the held-back set: this is the final ranking"),
    ],
)
def test_the_set_of_instances_is_told(held_back, expected, found):
    instances = [(*each, {"held_back": held}) for each, held in zip(INSTANCES, held_back)]
    assert any(expected in each for each in told(found(plan=contest_plan(METHODS, instances))))


def test_the_text_says_how_sure_the_first_is(found):
    [excess, _, speed, *_] = told(found())
    assert speed.startswith("how early targets of the excess are reached: lowest mean ranks fast 1.00 (1.00–1.00)")
    assert "fast is first in 100 % of resamples" in speed
    assert "3 instances cannot separate the two, 6 could" in speed  # 2^(1 − 6) < 0.05
    assert "both halves of the seeds are not shown to agree, Kendall's τ 1.00" in speed
    assert "intervals of 3 instances say too little; take 5 or more" in told(found())
    assert "fast is first in 50 %" in excess  # of two that tie


def test_a_report_from_records_to_the_page(tmp_path, capsys):
    methods = ("fast", "<b>slow</b>")
    plan = contest_plan(methods, INSTANCES)
    write_contest(plan, tmp_path, lambda label, *place: usual("fast" if label == "fast" else "slow", *place))
    assert collect(tmp_path) == 0
    out = capsys.readouterr().out
    assert out.startswith("2 methods on 3 instances of one_disk, two_disk, 2 draws each: 12 runs, 0 failed")
    names = {path.name for path in tmp_path.iterdir() if path.suffix in (".csv", ".png", ".html")}
    tables = {
        f"contest{end}.csv" for end in ("", "_ert", "_pairs", "_tests", "_ecdf", "_anytime", "_profiles", "_instances")
    }
    figures = {
        f"contest{end}.png"
        for end in ("_solved", "_ecdf_excess", "_ecdf_error", "_ranks", "_anytime", "_profiles", "_price")
    }
    assert names == {*tables, *figures, "runs.csv", "index.html"}
    assert pd.read_csv(tmp_path / "contest.csv").query("family == 'all'")["method"].tolist() == list(methods)
    page = (tmp_path / "index.html").read_text()
    assert "<b>" not in page and "&lt;b&gt;slow&lt;/b&gt;" in page
    for each in (
        "experiment contest",
        "commit c0de",
        "seed 0, repetitions 0 to 1",
        "optimizer=de",
        "problem.instance=2",
    ):
        assert each in page, each
    shown, linked = page.count("data:image/png"), sum(f'<a href="{name}">' in page for name in figures)
    assert shown > 0 and shown + linked == len(figures) and "http" not in page.replace("http-equiv", "")


def test_one_method_without_a_known_excess_is_drawn_too(tmp_path):
    def result(label, instance, repetition):
        made = usual(label, instance, repetition)
        return made | {"trace": made["trace"] | {"least": None}}

    plan = contest_plan(("fast",), INSTANCES, repetitions=1)
    made = ContestReport().make(plan, write_contest(plan, tmp_path, result))
    assert made.page is not None
    files = made.page().charts()
    assert {"contest_ranks.png", "contest_ecdf_error.png"} <= files.keys()
    assert all(figure(describe()).get_axes() for describe in files.values()) and "contest_ecdf_excess.png" not in files
    assert "one method alone, fast" in made.page().headline
    assert "one method alone, fast: nothing to rank" in made.text


def test_methods_have_symbols_of_their_own_not_colours_alone(found):
    compared = found()
    chart = ecdf_chart(ecdf_frame(compared, weights(compared)), compared.measures[0], METHODS)
    lines = [each for each in chart.panels[0].elements if each.name]
    assert [each.name for each in lines] == [*METHODS] and len({each.symbol for each in lines} - {""}) == 2


def test_ranks_ties_and_targets_that_no_run_reaches_are_drawn(found):
    """Two methods that tie share rank 1; one that never reaches the target has a word in place of a cost, an open cost an arrow."""
    compared = found()
    board = leaderboard(compared, weights(compared))
    measure, pairs = compared.measures[0], all_pairs_frame(compared)
    tied = solved_chart(board, pairs, measure, "title")
    assert list(tied.panels[0].y.ticks.values()) == ["=1 fast", "=1 slow"] and "no test separates" in tied.caption
    apart = solved_chart(board, pairs.assign(told_apart=True), measure, "title")
    assert "Tests separate any two methods" in apart.caption
    assert len(tied.panels[0].elements) == len(apart.panels[0].elements) + 1  # the bar that joins both
    is_slow = board["method"] == "slow"
    board.loc[is_slow, [f"{measure.name}_ert", f"{measure.name}_rank"]] = [np.inf, 2.0]
    board.loc[~is_slow, f"{measure.name}_ert_high"] = np.inf
    chart = solved_chart(board, pairs, measure, "title")
    cost = chart.panels[1].elements
    assert list(chart.panels[0].y.ticks.values()) == ["1 fast", "2 slow"]
    assert [each.text for each in cost if isinstance(each, Words)] == ["never"]
    assert [list(each.y) for each in cost if isinstance(each, Points) and each.symbol == "triangle right"] == [[0.0]]
    assert figure(chart).get_axes()


def test_curves_beyond_the_first_four_are_grey(found):
    names = tuple("abcdef")
    frame = pd.concat(
        [
            pd.DataFrame({"measure": "excess", "family": "all", "method": name, "cost_per_unknown": [1.0, 2.0],
                          "low": 0.0, "share": [0.0, 0.5], "high": 1.0}) for name in names
        ]
    )  # fmt: skip
    (panel,) = ecdf_chart(frame, found().measures[0], names).panels
    lines = [each for each in panel.elements if isinstance(each, Line)]
    assert [each.name for each in lines] == ["others", "others", *"abcd"] and [each.said for each in lines[:2]] == [
        "e",
        "f",
    ]
    assert sum(isinstance(each, Band) for each in panel.elements) == 4


def test_before_anything_is_run_there_is_nothing_to_rank(tmp_path):
    plan = contest_plan(METHODS, INSTANCES)
    made = ContestReport().make(plan, write_contest(plan, tmp_path, lambda *place: None))
    assert made.text.startswith("nothing to rank") and list(made.files) == ["runs.csv"]
    assert (made.runs["status"] == "not run").all()


def test_any_experiment_of_methods_and_instances_can_be_ranked(enter, monkeypatch):
    """Without labels methods are called by their plugins, whose final step a comparison leaves out; instances are whatever differs in problem
    and measurement."""
    monkeypatch.setattr("bench.reports.collect._png", lambda chart: b"")
    words = ["table=contest", "optimizer=de,random_search", "problem.mesh=9,13", "measurement.relative=0.1"]
    ended = enter("method=direct", "method.budget=30", "study.intervals=none", *words, "repetitions=2", "workers=1")
    assert ended.code == 0, ended.err
    assert ended.out.startswith("2 methods on 2 instances of three_disk, 2 draws each: 8 runs, 0 failed")
    board = ended.table("run")
    assert set(board["method"]) == {"direct + de", "direct + random_search"} and (board["evaluations"] == 30).all()
    assert ended.table("run_instances")["settings"].tolist() == ["problem.mesh=9", "problem.mesh=13"]
    assert "method=direct method.final_step=False optimizer=random_search" in (ended.output / "index.html").read_text()


def test_the_page_says_what_each_method_is():
    plan = contest_plan(METHODS, INSTANCES, budget=1000)
    cell = plan.cells[0]
    other = dataclasses.replace(
        cell,
        place={**cell.place, "label": "mine"},
        settings={**cell.settings, "optimizer": {"name": "mine", "step": 0.1}},
    )
    plan = dataclasses.replace(plan, cells=(*plan.cells, other), plugins={"optimizer=mine": "/home/me/mine.py"})
    rows = entrants_frame(plan).set_index("method")
    assert rows.loc["fast", "settings"] == "method=direct optimizer=de optimizer.population=20"
    assert rows.loc["fast", "from"].startswith("ksmea-bench") and rows.loc["fast", "budget"] == "1000"
    assert rows.loc["mine", "settings"] == "method=direct optimizer=mine optimizer.step=0.1"
    assert rows.loc["mine", "from"].endswith(", mine.py")  # no path of anyone's machine
    unknown = dataclasses.replace(plan, plugins={})
    assert (
        "optimizer=mine, which is not installed here" in entrants_frame(unknown).set_index("method").loc["mine", "from"]
    )
