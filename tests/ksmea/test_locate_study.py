"""A location as record, text, table and figure."""

import dataclasses
import json
import re

import numpy as np
import pytest
from matplotlib.figure import Figure

from bench.plan.page import Drawn, Folded
from bench.reports.diagnosis.location_page import location_blocks
from ksmea.errors import SettingError
from ksmea.extended_model import located_yaml
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.problem.case import Case
from ksmea.problem.load import Load
from ksmea.records.location import LocationRecord
from ksmea.show.charts.chart import Line
from ksmea.show.charts.location_chart import location_chart
from ksmea.show.json_units import with_units
from ksmea.show.location_text import frame, plot, text
from ksmea.show.location_words import headline, landmark
from ksmea.studies.locate import LocationOptions, location
from problems.three_disk import ThreeDisk

TRUTH = np.array([50e6, 70e6, 500.0, 700.0, 2e-4])
PROBLEM = ThreeDisk(sensors=[0.1, 0.5, 1.0], n_speed=30).build()
OPTIONS = LocationOptions(positions=[0.9, 1.0, 0.3], kinds=["force"])


def located(force, options=OPTIONS):
    """The record of data with a force (N) in x at 1 m, of constant size and phase."""
    return located_beside(np.array([force, 0.0]), "force", options)


def located_beside(acting, quantity, options):
    """The record of data with a load (2,) or (n_speed, 2), N or N m, at 1 m."""
    columns = PROBLEM.load_response(TRUTH[None], [Load(1.0, axis, quantity) for axis in "xy"])[0]
    response = PROBLEM.response(TRUTH[None])[0] + (columns @ acting[..., None])[..., 0]
    values = observe(response, "complex", Noise(0.05, 1e-7), np.random.default_rng(1))
    data = Measurement(PROBLEM.speed, PROBLEM.channels, values, None, "test")
    return location(Case(PROBLEM, data), np.random.default_rng(0), options=options)


@pytest.fixture(scope="module")
def record():
    return located(40.0)


def test_the_record_comes_back_from_json(record):
    assert LocationRecord.from_data(json.loads(json.dumps(record.to_data(), allow_nan=False))) == record


def test_json_tells_no_law_from_none_sought(record):
    """A law that is null may have been rejected, or never been looked for."""
    none_holds = tuple(dataclasses.replace(law, accepted=False) for law in record.laws)
    statuses = {"found": record.laws, "none holds": none_holds, "not sought": ()}
    told = {name: with_units(dataclasses.replace(record, laws=laws)) for name, laws in statuses.items()}
    assert [each["law_status"] for each in told.values()] == list(statuses)
    assert [each["law"] is None for each in told.values()] == [False, True, True]


def test_an_older_record_has_single_sites_and_names_of_laws(record):
    data = json.loads(json.dumps(record.to_data()))
    later = {"n_channel", "second", "key", "amplitude_sd"}

    def without(value):
        if isinstance(value, dict):
            return {name: without(each) for name, each in value.items() if name not in later}
        return [without(each) for each in value] if isinstance(value, list) else value

    older = LocationRecord.from_data(without(data))
    assert older.sites[0].positions == (1.0,)
    assert f"it acts as {record.law.law}: " in text(older)
    assert len(plot(older).get_axes()) == 5  # sites and shaft, and what acts there


def test_sites_are_ranked_and_the_best_is_the_true_one(record):
    assert record.kind == "force"
    assert (record.sites[0].position, record.sites[0].kind) == (1.0, "force")
    assert [site.accepted for site in record.candidates] == sorted(
        (s.accepted for s in record.candidates), reverse=True
    )
    assert record.candidates[-1].position == 0.3 and not record.candidates[-1].accepted


def test_intervals_over_sites_hold_those_of_the_best_site_and_the_truth(record):
    for value, each in zip(PROBLEM.parameters.in_units(TRUTH), record.coefficients):
        for end, sign in (("low", 1), ("high", -1)):
            over, best = getattr(each.over_sites, end), getattr(each.best, end)
            assert over is None or (best is not None and sign * over <= sign * best)
        assert (each.over_sites.low or -np.inf) <= value <= (each.over_sites.high or np.inf)


def test_the_force_has_the_size_and_the_phase_that_acts(record):
    parts = {part.part: part for part in record.force.parts}
    x = parts["x"]
    held = [low <= 40.0 <= high for low, high in zip(x.real.low, x.real.high)]
    assert np.mean(held) > 0.8  # 95 % of 30 speeds, but for errors of the unknowns that they share
    assert x.unit == "N"
    assert np.median(parts["y"].amplitude.value) < 0.5 * np.median(x.amplitude.value)
    assert {"forward", "backward"} <= set(parts)  # a force in x alone is half of each
    assert len(record.force.work.value) == len(record.speed) == 30


def test_the_text_says_where_and_what(record):
    said = text(record)
    assert said.startswith("The model does not fit: its residuals are not noise (p = ")
    assert "An unknown force that is free at every speed explains the data at " in said
    assert "1 m (disk 3)" in said
    assert "forward and backward alike" in said
    assert record.law.key == "smooth"  # all others are whirls or follow the motion
    assert "it follows none of the simple laws but changes smoothly with speed (4 knots)" in said
    assert "unknown    unit  beside it" in said
    assert all(len(line) < 160 for line in said.splitlines())


def test_the_text_says_where_nothing_is_missing_and_where_nothing_is_enough(record):
    plain = located(0.0)
    assert plain.kind == "nothing" and plain.force is None
    assert "nothing needs to be located" in text(plain) and "explains the data" not in text(plain)
    none = dataclasses.replace(
        record,
        kind="none",
        force=None,
        candidates=tuple(dataclasses.replace(site, accepted=False, p=0.001) for site in record.candidates),
    )
    assert "Nothing that was tried explains the data (force)" in text(none)
    for each in (plain, none):
        assert plot(each).get_axes()


def test_the_table_has_a_row_per_site(record):
    table = frame(record)
    assert list(table["position_m"]) == [site.position for site in record.candidates]
    assert table.loc[table["position_m"] == 1.0, "at"].item() == "disk 3" == landmark(record, 1.0)
    assert landmark(record, 0.9) == ""


def test_the_figure_has_the_shaft_the_force_the_work_and_the_stiffness(record):
    assert len(plot(record).get_axes()) == 5  # sites and shaft, and what acts there
    axes = Figure().subplots()
    assert plot(record, axes).get_axes() == [axes]


def test_a_reading_has_a_size_in_micrometres_and_does_no_work():
    values = PROBLEM.response(TRUTH[None])[0]
    values[:, 2] *= 1.4  # x at 0.5 m
    noisy = observe(values, "complex", Noise(0.05, 1e-7), np.random.default_rng(2))
    data = Measurement(PROBLEM.speed, PROBLEM.channels, noisy, None, "test")
    options = LocationOptions(kinds=["reading"])
    record = location(Case(PROBLEM, data), np.random.default_rng(0), options=options)
    assert record.kind == "reading" and record.force.work is None and record.force.stiffness == ()
    assert "µm (0-peak, at the middle" in text(record)
    assert len(plot(record).get_axes()) == 3


def test_a_skewed_disk_is_a_moment_with_a_law_of_its_own():
    moment = 2e-5 * PROBLEM.speed[:, None] ** 2 * np.array([1, -1j])
    record = located_beside(moment, "moment", LocationOptions(positions=[0.5, 1.0], kinds=["force", "moment"]))
    assert (record.kind, record.law.key, record.law.kind, record.law.position) == ("moment", "skew", "moment", 1.0)
    assert "At 1 m (disk 3), it is a moment ∝ Ω² that turns with the shaft, as of a skewed disk: " in text(record)
    assert re.search(r"the moment is x [-+0-9.e]+ to [-+0-9.e]+ N m, y [-+0-9.e]+ to [-+0-9.e]+ N m", text(record))
    assert plot(record).get_axes()


def test_an_unknown_kind_is_refused_with_the_known_ones():
    with pytest.raises(SettingError, match=r"torque.*force"):
        LocationOptions(kinds=["torque"])


def everywhere(record):
    """The record with all that was tried accepted."""
    candidates = tuple(dataclasses.replace(each, accepted=True) for each in record.candidates)
    return dataclasses.replace(record, candidates=candidates)


def test_a_headline_says_no_place_where_most_are_as_likely(record):
    assert headline(record).startswith("An unknown force at 1 m")
    anywhere = everywhere(record)
    assert "Its cause is spread over the shaft (100 % of all places explain the data)" in text(anywhere)
    for said in (headline(anywhere), plot(anywhere).get_suptitle()):
        assert said.startswith("Something unknown explains the data, spread over the shaft")


def test_a_spread_cause_is_shown_without_a_force_at_its_best_site(record):
    """Nor are the unknowns beside it; a law is stated on the condition that the cause is at one place."""
    said, page = text(everywhere(record)), [*location_blocks(everywhere(record))]
    assert "the force is x" in text(record) and "the force is x" not in said and "beside it" not in said
    assert "If it acts at one place alone:\nAt 1 m (disk 3)" in said
    assert len(plot(record).axes) > len(plot(everywhere(record)).axes) == 2
    assert [type(each) for each in page] == [Drawn, Folded] and len([*location_blocks(record)]) == 3


def test_an_extended_model_is_written_only_for_a_cause_at_a_place(record):
    assert "local_force" in located_yaml("three_disk", {}, record, ())
    assert not located_yaml("three_disk", {}, everywhere(record), ())


def accepted_at(record, **positions):
    """The record of a location with these positions accepted, by kind, of forces and moments at ten places."""
    site = record.candidates[0]
    candidates = [
        dataclasses.replace(site, kind=kind, position=0.1 * index, accepted=index in positions.get(kind, ()))
        for kind in ("force", "moment")
        for index in range(10)
    ]
    return dataclasses.replace(record, candidates=tuple(candidates), kind="force", laws=())


@pytest.mark.parametrize(("n_accepted", "is_spread"), [(1, False), (2, False), (3, True)])
def test_a_cause_is_spread_over_three_of_the_stated_places_or_more(record, n_accepted, is_spread):
    stated = [dataclasses.replace(each, accepted=index < n_accepted) for index, each in enumerate(record.candidates)]
    assert len(stated) == 3
    some = dataclasses.replace(record, candidates=tuple(stated), laws=())
    assert some.is_anywhere is some.is_spread is is_spread


def test_what_a_third_of_all_places_explain_is_not_located(record):
    """Forces at some places and moments at others count together: damping of a whole shaft is done by either."""
    assert accepted_at(record, force=(4, 5), moment=(4, 5)).is_local
    assert not accepted_at(record, force=(0, 2, 5, 7)).is_local
    assert not accepted_at(record, force=(3, 4), moment=(6, 7)).is_local
    several = accepted_at(record, force=(3, 4), moment=(6, 7))
    assert several.share_of_places == pytest.approx(0.4)
    by_law = dataclasses.replace(several, laws=(dataclasses.replace(record.law, position=0.3),))
    assert by_law.is_local and by_law.law_class  # a law that holds at one of them tells which
    assert not dataclasses.replace(everywhere(record), laws=by_law.laws).is_local


def test_kinds_that_the_data_do_not_tell_apart_are_alternatives(record):
    best, *others = record.candidates
    moment = dataclasses.replace(best, kind="moment", position=0.3)
    both = dataclasses.replace(record, candidates=(best, moment, *others), laws=())
    assert not both.is_spread and " or moment at 0.3 m" in headline(both)


def test_a_location_is_shown_in_the_units_of_the_measurement(record):
    """The noise and speeds in words and on axes; numbers of the record stay SI, and default units are not written."""
    own = record.shown_in("mil_pp,Hz")
    assert "notation" not in record.to_data() and LocationRecord.from_data(own.to_data()) == own
    assert {name: value for name, value in own.to_data().items() if name != "notation"} == record.to_data()
    floor = f"{record.noise.floor / 12.7e-6:.3g} mil pp"
    assert floor in text(own) and " rpm" not in text(own) and " µm" not in text(own)
    panels = location_chart(own).stacks[1]
    assert {panel.x.label for panel in panels} == {"speed (Hz)"}
    line = next(each for each in panels[0].elements if isinstance(each, Line))
    assert np.asarray(line.x) == pytest.approx(np.array(record.speed) / (2 * np.pi)) and " Hz: " in line.said
