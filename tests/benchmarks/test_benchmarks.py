"""The command `python -m benchmarks`: its groups, table, page and check."""

import ast
import dataclasses
import math
import os
import time
from pathlib import Path

import numpy as np
import pytest

import ksmea
from benchmarks.harness import command
from benchmarks.harness.figure import ratio_chart
from benchmarks.harness.machine import this_machine
from benchmarks.harness.measure import Measured, measured
from benchmarks.harness.processes import started
from benchmarks.harness.report import page, text
from benchmarks.harness.row import HERE, WALL, Contestant, Row
from benchmarks.harness.setup import required
from benchmarks.harness.table import COLUMNS, fallen, lines_of, merged, read, same_ratios, table, write
from benchmarks.tasks.diagnose_here import PARTS, by_part
from ksmea.errors import SettingError
from ksmea.show.charts.picture import png
from tiers import mostly_slow

ROOT = Path(__file__).resolve().parents[2]
NOWHERE = Path("/nowhere")
SMALLEST = {  # a row of each group by its title, and how many of its contestants are timed here
    "fe": ("one evaluation, 53 speeds", 2),
    "surrogate": ("Kriging fit, 106 outputs, 40 samples", 2),
    "optimizers": ("by pso", 2),
    "identification": ("exact data", 1),
    "framework": ("framework: import", 2),
    "scaling": ("set-up and one evaluation, 13 elements", 1),
}


def lines(ratios=(4.0,), group="fe", size=None, name="row", **fields):
    """A row's lines: ours takes 1 s, each of the others as many as its ratio says."""
    others = tuple(Contestant(f"other {number}", "a:b", at_least=3.0) for number in range(len(ratios)))
    row = Row(group, name, (Contestant("here", "a:b"), *others), size=size, **fields)
    found = [Measured(each, "library 1", 1, [1.0, 2.0, 1.0]) for each in row.contestants]
    for each, ratio in zip(found[1:], ratios):
        each.seconds = [ratio, 2 * ratio, ratio]
    return lines_of(row, found, this_machine())


@pytest.mark.parametrize("group", mostly_slow(SMALLEST, but=["fe", "framework"]))
def test_the_smallest_row_of_a_group_is_measured_without_peers(group):
    title, n_here = SMALLEST[group]
    row = next(row for row in command.GROUPS[group]() if title in row.title)
    here = [each for each in row.contestants if each.environment == HERE][:n_here]
    with started(NOWHERE) as processes:
        found = measured(dataclasses.replace(row, contestants=tuple(here)), processes, 1)
    assert [each.skipped for each in found] == [""] * n_here
    assert all(len(each.seconds) == 1 and each.seconds[0] > 0 for each in found)
    if row.quality:
        assert all(each.quality is not None and 0 <= each.quality < math.inf for each in found)
    if group == "fe":
        # two routes through the same elements, the largest over 100 sets; condition numbers of 1e6
        assert found[1].difference < 1e-9


@pytest.mark.parametrize("group", command.GROUPS)
def test_every_row_asks_for_a_task_that_takes_its_settings(group):
    """Also those whose library is not here: read, not imported."""
    rows = command.GROUPS[group]()
    assert len({(row.title, each.name) for row in rows for each in row.contestants}) == sum(
        len(row.contestants) for row in rows
    )
    for row in rows:
        assert row.group == group
        for each in row.contestants:
            module, _, function = each.task.partition(":")
            tree = ast.parse((ROOT / f"{module.replace('.', '/')}.py").read_text(encoding="utf-8"))
            (definition,) = [node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == function]
            taken = [argument.arg for argument in definition.args.args]
            needed = taken[: len(taken) - len(definition.args.defaults)]
            assert set(needed) <= set(each.settings) <= set(taken), each


def test_a_table_says_where_it_was_measured_and_is_read_as_written(tmp_path):
    frame = table(lines((4.0, 2.0), size=53, no_more_than=1.5))
    write(frame, tmp_path / "deep" / "benchmarks.csv")
    back = read(tmp_path / "deep" / "benchmarks.csv")
    assert tuple(back.columns) == COLUMNS and os.listdir(tmp_path / "deep") == ["benchmarks.csv"]
    assert back["seconds"].tolist() == [1, 4, 2] and back["ratio"].tolist()[1:] == [4, 2]
    assert back["reached"].tolist() == ["yes", "yes", "no"]
    for name, value in this_machine().items():
        assert set(back[name].astype(str)) == {str(value)} and str(value)


def test_a_reason_stands_where_there_is_no_time():
    row = Row("fe", "row", (Contestant("here", "a:b"), Contestant("peer", "a:b", at_least=10.0)), clock=WALL)
    found = [Measured(row.contestants[0], "x 1", 1, [1.0]), Measured(row.contestants[1], skipped="<b> is absent")]
    frame = table(lines_of(row, found, this_machine()))
    assert frame.loc[1, "skipped"] == "<b> is absent" and frame.loc[1, "reached"] == ""
    assert "peer  skipped: <b> is absent" in text(frame) and "fe: row; wall time per call" in text(frame)
    shown = page(frame, png(ratio_chart(frame))).decode()
    assert "&lt;b&gt; is absent" in shown and "<b> is" not in shown and "https:" not in shown


def test_parts_are_shares_of_the_whole():
    row = Row("diagnosis", "row", (Contestant("here", "a:b"),))
    found = Measured(row.contestants[0], "x 1", 1, [4.0], parts=[{"fits": 3.0, "rest": 1.0}])
    frame = table(lines_of(row, [found], this_machine()))
    assert frame["contestant"].tolist() == ["here", "here: fits", "here: rest"]
    assert frame["seconds"].tolist() == [4, 3, 1] and frame["ratio"].tolist()[1:] == [0.75, 0.25]
    assert "here: fits  3 s  75 %" in text(frame) and "no contestant" in ratio_chart(frame).title


def test_growth_is_fitted_to_three_sizes_or_more():
    series = [line for size in (1, 2, 4) for line in lines((float(size) ** 2,), size=size, size_of="nodes")]
    series += [line for size in (1, 2, 4) for line in lines((float(size),), size=size, size_of="speeds")]
    frame = table([*series, *lines((1.0,), name="another", size=1)])
    other = frame[(frame["row"] == "row") & (frame["contestant"] == "other 0")]
    assert other["exponent"].to_numpy() == pytest.approx(np.repeat([2.0, 1.0], 3))
    assert frame.loc[frame["row"] == "another", "exponent"].isna().all()


def test_rows_measured_again_replace_those_of_the_table():
    old, new = table([*lines((4.0,)), *lines((5.0,), name="kept")]), table(lines((6.0,)))
    both = merged(old, new)
    assert dict(zip(both["row"], both["ratio"].fillna(0))) == {"kept": 5.0, "row": 6.0} and len(both) == 4


def test_a_series_may_be_measured_in_parts(tmp_path):
    whole = None
    for size in (1, 2, 4, 2):  # the third is measured again
        now = table(lines((float(size) ** 2,), size=size, size_of="nodes"))
        whole = now if whole is None else merged(read(tmp_path / "x.csv"), now)
        write(whole, tmp_path / "x.csv")
    assert sorted(whole["size"]) == [1, 1, 2, 2, 4, 4]
    assert whole.loc[whole["contestant"] == "other 0", "exponent"].to_numpy() == pytest.approx(2.0)


def test_what_fell_by_more_than_a_third_is_found():
    committed = table([*lines((30.0, 8.0)), *lines((6.0,), size=53), *lines((9.0,), name="only there")])
    now = table([*lines((19.0, 5.4)), *lines((3.9,), size=53), *lines((1.0,), name="only here")])
    both = same_ratios(now, committed)
    assert len(both) == 3
    assert fallen(both)[["contestant", "ratio_now", "ratio"]].to_numpy().tolist() == [
        ["other 0", 19, 30],
        ["other 0", 3.9, 6],
    ]
    assert fallen(both)["size"].fillna(0).tolist() == [0, 53]
    assert fallen(same_ratios(committed, committed)).empty


def test_check_exits_with_0_and_says_what_it_saw(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(command, "each_measured", lambda *arguments: iter([lines((1.0,))]))
    write(table(lines((30.0,))), tmp_path / "committed.csv")
    code = command.main(["check", "fe", "--quick", "--against", str(tmp_path / "committed.csv")])
    said = capsys.readouterr().out.splitlines()
    assert code == 0 and said[0].startswith("slower: fe: row, other 0: 1 × here, 30 × committed")
    assert said[1] == "1 ratios compared with committed.csv: 1 fell by more than a third"


def test_a_run_writes_table_picture_and_page(tmp_path, monkeypatch, capsys):
    groups = ("fe", "optimizers")
    monkeypatch.setattr(command, "each_measured", lambda *others: (lines((3.5,), group=group) for group in groups))
    assert command.main(["fe", "optimizers", "--out", str(tmp_path)]) == 0
    assert "3.5 ×" in capsys.readouterr().out
    assert read(tmp_path / "benchmarks.csv")["group"].tolist() == ["fe", "fe", "optimizers", "optimizers"]
    assert (tmp_path / "benchmarks.png").read_bytes()[:4] == b"\x89PNG"
    assert "<h1>Side by side</h1>" in (tmp_path / "benchmarks.html").read_text(encoding="utf-8")


def test_an_interrupted_run_has_what_was_measured(tmp_path, monkeypatch):
    def interrupted(*arguments):
        yield lines((3.5,))
        raise KeyboardInterrupt

    monkeypatch.setattr(command, "each_measured", interrupted)
    assert command.main(["fe", "--out", str(tmp_path)]) == command.INTERRUPTED == 130
    assert read(tmp_path / "benchmarks.csv")["ratio"].tolist()[1] == 3.5 and (tmp_path / "benchmarks.html").is_file()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["fee"], "group"),
        (["fe", "--repetitions", "0"], "expected a whole number of at least 1, got 0"),
        (["fe", "--repetitons", "3"], "--repetitons"),
        (["fe", "--only", "no such row"], "none has 'no such row'"),
        (["check", "--against", "/nowhere/x.csv"], "found no file"),
    ],
)
def test_bad_input_is_one_line_and_2(words, said, capsys):
    assert command.main(words) == 2
    printed = capsys.readouterr()
    assert said in printed.err and len(printed.err.splitlines()) == 1 and not printed.out


def test_a_file_that_is_no_table_is_refused(tmp_path):
    (tmp_path / "x.csv").write_text("a,b\n1,2\n")
    with pytest.raises(SettingError, match="expected the columns group, row"):
        read(tmp_path / "x.csv")


def test_setup_does_not_touch_a_folder_of_something_else(tmp_path, capsys):
    (tmp_path / "notes.txt").write_text("mine")
    assert command.main(["setup", str(tmp_path)]) == 2
    assert "found other files" in capsys.readouterr().err and os.listdir(tmp_path) == ["notes.txt"]


def test_the_extra_names_every_peer():
    names = {requirement.split(">")[0].split("<")[0] for requirement in required()}
    asked = {
        each.library
        for rows in command.GROUPS.values()
        for row in rows()
        for each in row.contestants
        if each.environment != HERE
    }
    assert asked <= names


def test_committed_results_are_of_rows_that_there_are_and_of_committed_code():
    committed = read(command.COMMITTED)
    titles = {(row.group, row.name) for rows in command.GROUPS.values() for row in rows()}
    assert set(committed[["group", "row"]].itertuples(index=False, name=None)) <= titles
    assert set(committed["group"]) >= set(command.GROUPS) - {"table3"}  # that wants an idle machine
    assert not committed["commit"].str.endswith("+").any() and np.isfinite(committed["cores"]).all()


def test_parts_of_a_diagnosis_add_up_to_all_of_it():
    rotor = ksmea.load_problem("three_disk", n_speed=15, sensors=[0.1, 0.5])
    data = ksmea.synthetic_measurement(rotor, relative=0.05, kind="complex", rng=1)
    started = time.process_time()
    _, parts = by_part(lambda: ksmea.diagnose(rotor, data, effects=["runout"], locate=False))
    whole = time.process_time() - started
    assert {"screening", "baseline", "fits", "intervals", "observability"} <= set(parts) <= {*PARTS, "rest"}
    assert 0.8 * whole < sum(parts.values()) <= whole  # what is left out is the patching itself
