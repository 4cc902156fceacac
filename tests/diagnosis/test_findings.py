"""Findings of a diagnosis in words and pictures: title, certainty, other explanations, values; page and picture draw the same."""

import dataclasses

import numpy as np
import pytest

from bench.plan.page import Command, Drawn, Grid, Numbers, Prose, Steps, Table
from bench.reports.diagnosis.page import MOST_STEPS, diagnosis_page, pictures_of
from ksmea.measurement.notation import Notation
from ksmea.records.diagnosis import CoefficientRecord
from ksmea.records.estimate import EstimateRecord
from ksmea.records.statement import SizeRecord, StatementRecord
from ksmea.show import diagnosis_findings as findings
from ksmea.show.charts import interactive, picture
from ksmea.show.charts.cause_charts import cause_chart, orbit_chart, others_chart, response_chart
from ksmea.show.charts.chart import Line, Points
from ksmea.show.charts.responses import of_diagnosis
from ksmea.show.diagnosis_text import evidence
from ksmea.show.diagnosis_values import value_table
from tests.diagnosis.test_show import RECORD, ambiguous, changed

SIZE = SizeRecord(12.8, 12.71, 12.89, "µm", 71.0, 0.4)
STATED = StatementRecord(
    "runout",
    "Runout of {runout:reading}, seen by {place:probes}",
    {"runout": SIZE},
    "at 0.1 m",
    "Record a slow-roll vector.",
)
OWN = Notation("mil", "pp", "lag", names={"x at 0.1 m": "3X", "y at 0.1 m": "3Y"})
NAMED = changed(applied=(dataclasses.replace(RECORD.applied[0], statement=STATED),))


def test_the_title_is_the_finding_in_the_notation_of_the_data():
    """12.8 µm 0-peak are 25.6 µm pp, 1.008 mil pp; a lead of 71° is a lag of 289°."""
    assert findings.title(NAMED, OWN) == "Runout of 1.01 mil pp at 289° lag, seen by 3X and 3Y"
    assert findings.file_line(NAMED, OWN).endswith(
        "12 speeds, 1910 rpm to 14\u2009324 rpm · probes 3X, 3Y · mil pp, phase lag"
    )


def test_the_title_of_each_verdict_is_a_sentence_without_code_words():
    records = [changed(verdict=each) for each in ("adequate", "not observable", "unknown")]
    for record in [*records, ambiguous(), RECORD]:
        said = findings.title(record)
        assert said[0].isupper() and "_" not in said and "Verdict" not in said
    assert findings.title(ambiguous()) == "Runout at 0.1 m or mass: these data cannot distinguish them"


def test_an_error_of_the_measurement_is_said_to_be_none_of_the_machine():
    """Only if every cause is one: of a pair, and of explanations that cannot be distinguished, too."""
    said = "This is an error of the measurement: the machine itself agrees with the model."
    of_reading = dataclasses.replace(RECORD.applied[0], statement=dataclasses.replace(STATED, is_of_measurement=True))
    assert findings.meaning(changed(applied=(of_reading,))).endswith(said)
    assert "Each is an error" in findings.meaning(changed(applied=(of_reading, of_reading)))
    for applied in (NAMED.applied, (of_reading, *NAMED.applied)):
        assert "error of the measurement" not in findings.meaning(changed(applied=applied))
    assert "error of the measurement" not in findings.meaning(ambiguous())


def test_certainty_has_at_most_four_numbers():
    said = dict(findings.certainty(NAMED))
    assert list(said) == ["± 0.09 µm 0-peak, ± 0.4°", "× 57", "6 of 6", "p = 0.99"]
    assert said["× 57"] == "as much noise is needed for mass, the only other cause: ruled out"
    assert said["6 of 6"].endswith("than as given") and said["p = 0.99"].startswith(
        "no lack of fit (rejected below 0.005);"
    )
    rejected = changed(verdict="unknown")
    assert next(findings.certainty(rejected))[1].startswith("lack of fit (rejected below 0.005);")
    for verdict in ("adequate", "unknown", "not observable"):
        assert len(list(findings.certainty(changed(verdict=verdict)))) <= 4


def test_a_cause_that_needs_little_more_noise_has_odds():
    """exp(ΔBIC/2): 18 behind are 8103 to 1, 60 behind more than a million to 1; 5 behind is not ruled out."""
    best = RECORD.ranking[0]
    for behind, big in ((18.0, "8\u00a0100 to 1"), (60.0, "more than 1\u00a0000\u00a0000 to 1")):
        near = dataclasses.replace(
            RECORD.ranking[1], deviance_drop=best.deviance_drop - 1.0, delta_bic=best.delta_bic - behind
        )
        said = dict(findings.certainty(changed(ranking=(best, near))))
        assert said[big].startswith("odds by BIC against mass, the only other cause: the data fit it with × 1.0")
    near = dataclasses.replace(RECORD.ranking[1], deviance_drop=best.deviance_drop, delta_bic=best.delta_bic - 5.0)
    assert dict(findings.certainty(changed(ranking=(best, near))))["× 1.00"].endswith("only other cause: not ruled out")


def test_a_size_on_its_physical_limit_is_said_at_the_top():
    [first, *others] = RECORD.ranking
    part = dataclasses.replace(first.parameters[0], at_limit=True)
    limited = changed(ranking=(dataclasses.replace(first, parameters=(part, *first.parameters[1:])), *others))
    assert " ends at its physical limit: a part that acts much like it is possible, too." in findings.meaning(limited)
    assert "limit" not in findings.meaning(RECORD)


def test_what_fits_best_of_several_is_said_with_its_size():
    best = dataclasses.replace(ambiguous(), applied=NAMED.applied)
    assert "Best fit: Runout of 12.8 µm 0-peak at 71° lead" in findings.meaning(best)


def test_the_noise_that_a_cause_needs_is_a_ratio_of_rms_residuals():
    """Estimated: the deviance of n data is n ln s². Known: it is χ², of which the best one leaves n times its reduced χ²."""
    [other] = findings.others(RECORD)
    rise = RECORD.ranking[0].deviance_drop - other.trial.deviance_drop
    n = 2 * len(RECORD.curves.speed) * len(RECORD.curves.channels)
    known = np.sqrt(1 + rise / (n * RECORD.lack_of_fit.after.reduced_chi2))
    assert RECORD.noise.known and other.multiple == pytest.approx(known)
    near = dataclasses.replace(RECORD.ranking[1], deviance_drop=RECORD.ranking[0].deviance_drop - 2 * n * np.log(1.5))
    estimated = changed(noise=dataclasses.replace(RECORD.noise, known=False), ranking=(RECORD.ranking[0], near))
    assert findings.others(estimated)[0].multiple == pytest.approx(1.5)


def test_a_p_at_the_resolution_of_the_simulation_is_said_as_such():
    """A statistic is named only if it is alone there."""
    before = RECORD.lack_of_fit.before
    lowest = dataclasses.replace(before, p=1 / 4001, p_by_statistic={"χ²": 5e-5, "largest residual": 5e-5})
    assert findings.chance(lowest) == "p ≤ 1/4001"
    alone = dataclasses.replace(lowest, p_by_statistic={"χ²": 5e-5, "largest residual": 0.2})
    assert findings.chance(alone) == "p ≤ 1/4001, by χ²"
    assert findings.chance(dataclasses.replace(before, p=0.312)) == "p = 0.31"


def test_a_rejected_model_has_no_intervals():
    table = value_table(changed(verdict="unknown"))
    assert set(table["95 %"]) == {"wrong model"} and "±" not in table
    table = value_table(RECORD).set_index("")
    assert table.loc["kxx", "95 %"].startswith("± ") and table.loc["cxx", "95 %"].startswith("above")


def test_the_change_of_an_angle_is_in_degrees_the_short_way_round():
    """From 170° to −175° are 15° ahead, not −203 %; and an angle has no relative half-width."""
    before = EstimateRecord("phase1", "deg", 170.0, 168.0, 172.0, "information", False)
    after = dataclasses.replace(before, value=-175.0, low=-176.0, high=-174.0)
    table = value_table(changed(coefficients=(CoefficientRecord("phase1", before, after),))).set_index("")
    assert table.loc["phase1", "moved by the cause"] == "+15°" and table.loc["phase1", "±"] == ""


def test_look_alikes_out_of_reach_are_said_to_be_ruled_out():
    record = changed(aliases={"mass": "weigh the rotor"})
    assert list(findings.look_alikes(record)) == [
        "Ruled out by these data, although it can look like it: mass (× 57 the noise)."
    ]
    near = dataclasses.replace(ambiguous(), aliases={"mass": "weigh the rotor"}, named=("runout",))
    assert list(findings.look_alikes(near)) == ["Mass cannot be ruled out: weigh the rotor."]


def test_the_page_has_the_finding_four_numbers_two_pictures_and_three_steps_at_most():
    commands = [Command(f"python -m bench {number}") for number in range(4)]
    page = diagnosis_page(dataclasses.replace(NAMED, notation=OWN), commands)
    assert page.headline == findings.title(NAMED, OWN)
    blocks = [block for section in page.sections for block in section.blocks]
    assert [len(each.items) for each in blocks if isinstance(each, Numbers)] == [4]
    assert [len(each.plots) for each in blocks if isinstance(each, Grid)] == [2]
    [steps] = [each.steps for each in blocks if isinstance(each, Steps)]
    assert len(steps) == MOST_STEPS and steps[0] == Prose("Record a slow-roll vector.")
    assert len([each for each in blocks if isinstance(each, Table)]) == 1  # all other tables are folded
    assert pictures_of(NAMED) == {"finding.png", "cause.png", "effects.png", "residuals.png"}


CHARTS = {
    "response": lambda: response_chart(NAMED, OWN),
    "polar": lambda: cause_chart(NAMED, OWN),
    "orbit": lambda: orbit_chart(NAMED, of_diagnosis(NAMED, OWN)),
    "others": lambda: others_chart(NAMED),
}


@pytest.mark.parametrize("name", CHARTS)
def test_page_and_picture_agree_in_data_scale_and_labels(name):
    chart = CHARTS[name]()
    shown, drawn = interactive.plot(chart), picture.figure(chart)
    lines = [
        (np.asarray(each.x, dtype=float), np.asarray(each.y, dtype=float))
        for panel in chart.panels
        for each in panel.elements
        if isinstance(each, (Line, Points))
    ]
    traces = [
        (np.asarray(each["x"], float), np.asarray(each["y"], float))
        for each in shown["data"]
        if each.get("mode") in ("lines", "markers")
    ]
    of_axes = [axes for axes in drawn.axes]
    plotted = [(line.get_xdata(), line.get_ydata()) for axes in of_axes for line in axes.lines]
    for x, y in lines:
        for found in (traces, plotted):
            assert any(
                len(a) == len(x) and np.allclose(a, x, equal_nan=True) and np.allclose(b, y, equal_nan=True)
                for a, b in found
            )
    for number, (panel, axes) in enumerate(zip(chart.panels, of_axes), start=1):
        end = "" if number == 1 else str(number)
        for side in "xy":
            scale = getattr(panel, side)
            assert getattr(axes, f"get_{side}scale")() == scale.scale == shown["layout"][f"{side}axis{end}"]["type"]
    assert drawn.get_suptitle() == chart.title


def test_the_chart_of_the_response_is_in_the_unit_of_the_data():
    chart = response_chart(NAMED, OWN)
    measured = next(each for each in chart.panels[0].elements if isinstance(each, Points))
    response = of_diagnosis(NAMED)
    column = response.channels.index(RECORD.lack_of_fit.before.channel)
    assert np.allclose(measured.y, np.abs(response.measured[:, column]) * 2 / 25.4)
    assert chart.panels[0].y.label == "3X, mil pp"
    assert isinstance(diagnosis_page(NAMED, ()).sections[1].blocks[0].plots[0], Drawn)


def test_the_evidence_is_in_the_unit_of_the_data_too():
    """All channels by their names, the data and the noise in words, and the orbit: from −1 to 1 mil are 2 mil pp."""
    record = dataclasses.replace(NAMED, notation=OWN)
    [folded] = [each for each in diagnosis_page(record, ()).sections[-1].blocks if each.title.startswith("Response")]
    bode = folded.blocks[0].described()
    response = of_diagnosis(NAMED)
    named = [OWN.name(channel) for channel in response.channels]
    assert [stack[0].title for stack in bode.stacks] == named and "3X" in named
    assert bode.title == findings.title(NAMED, OWN)
    amplitude = bode.stacks[0][1]
    measured = next(each for each in amplitude.elements if isinstance(each, Points))
    assert amplitude.y.label == "amplitude (mil pp)"
    assert measured.y == pytest.approx(np.abs(response.measured[:, 0]) * 2 / 25.4)
    said = evidence(record)
    assert "amplitudes (mil pp) and phases (lag)" in said and " µm." not in said and "x at 0.1 m" not in said
    orbit = orbit_chart(NAMED, of_diagnosis(NAMED, OWN)).panels[0]
    whole = orbit_chart(NAMED, of_diagnosis(NAMED)).panels[0]
    assert orbit.x.label == "x, mil" and np.asarray(orbit.elements[0].x) == pytest.approx(whole.elements[0].x / 25.4)
