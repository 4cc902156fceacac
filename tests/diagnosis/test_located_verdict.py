"""A diagnosis that has no name for what is wrong says where it acts; beside a name it is a second opinion."""

import dataclasses
import json
from types import SimpleNamespace

import numpy as np
import pytest

from bench.plan.page import Drawn
from bench.reports.diagnosis.page import diagnosis_page
from ksmea.diagnosis.diagnosis import diagnose
from ksmea.diagnosis.located_verdict import is_doubtful, is_elsewhere, is_one_law, remark_on, without_names
from ksmea.errors import SettingError
from ksmea.problem.case import Case
from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.show.diagnosis_text import about_extension, text, why_without
from ksmea.studies.diagnose import DiagnosisOptions, diagnosis, diagnosis_record
from ksmea.studies.diagnosis_remarks import disagreements
from ksmea.studies.library import library
from tests.diagnosis.conftest import TRUTH, registered_effects

OPTIONS = DiagnosisOptions(screening=512, starts=4, scan=64, scan_values=8, effect_starts=3)


@pytest.fixture(scope="module")
def unnamed(rotor, hide):
    """The diagnosis of a further unbalance with an empty library, and what was hidden."""
    measurement, effect, size = hide("unbalance", 3)
    return diagnosis(Case(rotor, measurement), {}, np.random.default_rng(0), options=OPTIONS), effect, size


@pytest.fixture(scope="module")
def named(rotor, hide):
    """The record of the same data with the unbalance in the library, and the diagnosis that it is made of."""
    measurement, _, _ = hide("unbalance", 3)
    found = []

    def noted(*given):
        found.append(diagnose(*given))
        return found[-1]

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("ksmea.studies.diagnose.diagnose", noted)
        effects = {"unbalance": registered_effects()["unbalance"]}
        record = diagnosis(Case(rotor, measurement), effects, np.random.default_rng(0), options=OPTIONS)
    return record, found[-1]


@pytest.mark.slow
def test_without_a_library_the_place_is_found_and_the_law(unnamed):
    record, effect, size = unnamed
    assert record.verdict == "located" and not record.named and not record.ranking
    assert effect.position in [site.position for site in record.location.sites]
    law = record.location.law
    assert (law.key, law.position) == ("unbalance", effect.position)
    found = np.array([each.value for each in law.coefficients]) * 1e-6  # g mm
    assert np.all(np.abs(found - size) < 4 * 1e-6 * np.array([each.sd for each in law.coefficients]))


def test_beside_the_unknown_force_the_stiffnesses_stay_true(unnamed):
    record, _, _ = unnamed
    for each in record.location.coefficients[:2]:
        assert each.over_sites.holds(TRUTH[each.name] / 1e6)


def test_what_files_show_begins_with_kind_sites_and_law(unnamed):
    record, _, _ = unnamed
    told = record.shown_data()["location"]
    assert list(told)[:5] == ["kind", "sites", "law", "work", "force"]
    assert told["kind"] == "force" and told["sites"][0].keys() >= {"position", "p"}
    assert len(told["work"]["value"]) == len(told["speed"])
    again = DiagnosisRecord.from_data(json.loads(json.dumps(record.to_data())))
    assert again == record


def test_the_text_says_it_in_its_verdict_and_the_file_holds_the_law(unnamed):
    record, effect, _ = unnamed
    said = text(record)
    assert f"Verdict: located – an unknown force at {effect.position:g} m" in said
    assert "which acts as unbalance" in said and "no known effect was tried" in said
    assert said.index("Values whatever the cause is:") < said.index("Without the library:")
    assert said.count("over all sites") == 1 and "before" not in said
    assert "unbalance" in about_extension(record)[0] and record.location.extension is not None


@pytest.mark.slow
def test_a_law_counts_as_its_effect_does(unnamed, named):
    """An unbalance law and the effect of that name are one model, whose evidence is one number."""
    (record, effect, _), (by_name, _) = unnamed, named
    assert by_name.applied[0].settings["position"] == effect.position
    assert record.location.extension.delta_bic == pytest.approx(by_name.ranking[0].delta_bic, abs=0.1)  # ends of fits


def explained_at(*places, delta_bic=50.0):
    """A diagnosis on a machine that names one explanation, an effect at each of some lists of places."""
    acting = [SimpleNamespace(effect=SimpleNamespace(places=lambda machine, at=at: at)) for at in places]
    best = SimpleNamespace(applied=tuple(acting), delta_bic=delta_bic, names=("one", "other")[: len(places)])
    problem = SimpleNamespace(machine=None)
    return SimpleNamespace(explanations=(best,), baseline=SimpleNamespace(problem=problem))


@pytest.mark.parametrize(
    ("places", "is_sharp", "elsewhere"),
    [
        ([[0.5]], True, False),
        ([[0.2]], True, True),
        ([[]], True, True),  # all along the shaft
        ([[0.5], [0.2]], True, True),  # half of it acts elsewhere
        ([[0.5], [0.5]], True, False),
        ([[0.2]], False, False),
    ],
)
def test_names_are_elsewhere_only_beside_a_sharp_location(places, is_sharp, elsewhere):
    sites = SimpleNamespace(is_sharp=is_sharp, accepts=lambda place: place == 0.5)
    assert is_elsewhere(explained_at(*places), sites) is elsewhere


@pytest.mark.parametrize(
    ("better", "elsewhere", "is_law"),
    [
        *((45.0, True, True), (43.0, True, False), (80.0, True, True), (None, True, False)),
        *((45.0, False, False), (55.0, False, False), (57.0, False, True)),  # where the effects act, too
    ],
)
def test_a_law_takes_the_place_of_names_that_are_hardly_better(unnamed, better, elsewhere, is_law):
    """ΔBIC 50 of the names; 6 below is as good (Kass & Raftery 1995)."""
    where = unnamed[0].location
    where = dataclasses.replace(where, extension=dataclasses.replace(where.extension, delta_bic=better))
    found = explained_at([0.2], [])
    sites = SimpleNamespace(is_sharp=elsewhere, accepts=lambda place: False)
    assert is_one_law(found, where, sites) is is_law
    assert not is_one_law(SimpleNamespace(explanations=()), where, sites)
    said = remark_on(found, where)
    assert said.startswith("one with other would fit, but") and f"{where.law.position:g} m" in said


@pytest.mark.parametrize(("better", "is_law"), [(55.0, False), (57.0, True)])
def test_a_law_at_one_of_many_places_must_explain_clearly_better(unnamed, better, is_law):
    where = unnamed[0].location
    spread = dataclasses.replace(
        where,
        candidates=tuple(dataclasses.replace(each, accepted=True) for each in where.candidates),
        extension=dataclasses.replace(where.extension, delta_bic=better),
    )
    assert not spread.is_local
    assert is_one_law(explained_at([0.2]), spread, SimpleNamespace(is_sharp=False)) is is_law
    assert remark_on(explained_at([0.2]), spread).endswith("explains the data better")


@pytest.mark.parametrize(("p", "is_doubted"), [(0.006, True), (0.06, False)])
def test_an_explanation_whose_misfit_is_barely_likely_is_doubted(p, is_doubted):
    """One in twenty right explanations misfits as much; without an explanation nothing is to be doubted."""
    found = explained_at([0.5])
    found.best_quality = SimpleNamespace(p=p)
    assert is_doubtful(found) is is_doubted
    found.explanations = ()
    assert not is_doubtful(found)


@pytest.mark.slow
def test_without_names_a_diagnosis_is_unknown(named):
    _, found = named
    record = diagnosis_record(without_names(found))
    assert found.verdict == "named" and record.verdict == "unknown"
    assert not (record.named or record.applied or record.explanations or record.ambiguity_group)
    assert record.lack_of_fit.after is None and all(row.after is None for row in record.coefficients)


def test_nothing_is_located_in_a_model_that_is_right(rotor, hide):
    measurement, _, _ = hide(None, 5)
    record = diagnosis(Case(rotor, measurement), {}, np.random.default_rng(0), options=OPTIONS)
    assert record.verdict == "adequate" and record.location is None


def test_two_channels_leave_it_unknown(rotor, hide):
    """A force takes both complex numbers that they have at each speed."""
    measurement, _, _ = hide("unbalance", 3)
    few = dataclasses.replace(measurement, channels=measurement.channels[:2], values=measurement.values[:, :2])
    seen = rotor.at(few.speed, few.channels)
    record = diagnosis(Case(seen, few), {}, np.random.default_rng(0), options=OPTIONS)
    assert record.location is None and record.verdict in ("unknown", "adequate")


@pytest.mark.slow
def test_beside_a_name_it_is_a_second_opinion(unnamed, named):
    _, effect, _ = unnamed
    record, _ = named
    assert record.verdict == "named" and record.location.accepts(effect.position) and not record.remarks
    said = text(record)
    assert "Without the library: an unknown force at" in said
    assert said.count('Trust neither, but those "with the cause", of the extended model.') == 1
    [page] = [section for section in diagnosis_page(record, ()).sections if section.title == "Evidence"]
    [folded] = [block for block in page.blocks if getattr(block, "title", "") == "Location without the library"]
    drawn = [block.described() for block in folded.blocks if isinstance(block, Drawn)]
    assert why_without(record)[0] in drawn[-1].caption


class _Named:
    """A diagnosis that names an unbalance at a place."""

    def __init__(self, problem, effect):
        self.named = ("unbalance",)
        self.baseline = type("Fit", (), {"problem": problem})
        self.applied = (type("Candidate", (), {"name": "unbalance", "effect": effect}),)


def test_a_name_at_a_place_that_the_location_rejects_is_doubted(unnamed, rotor):
    record, effect, _ = unnamed
    rejected = next(float(position) for position in rotor.sites if not record.location.accepts(position))
    elsewhere = dataclasses.replace(effect, position=rejected)
    assert not disagreements(_Named(rotor, effect), record.location)
    [remark] = disagreements(_Named(rotor, elsewhere), record.location)
    assert f"acts at {elsewhere.position:g} m" in remark and f"force at {effect.position:g} m" in remark


def test_an_empty_library_is_asked_for_alone():
    assert library(["none"], []) == ({}, {})
    with pytest.raises(SettingError, match="expected none alone or names of effects, got none, mass"):
        library(["none", "mass"], [])
