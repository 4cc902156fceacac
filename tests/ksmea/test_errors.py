"""Errors of settings: what they are about, and what was meant, stays with them however they are located or sent."""

import pickle

from ksmea.errors import SettingError, UnknownName, unknown


def test_an_error_keeps_what_it_is_about_however_it_is_located_or_sent():
    error = unknown("value for misfit:", "Log", ["log"]).within("method=ksmea", "method.misfit")
    for each in (error, pickle.loads(pickle.dumps(error))):
        assert str(each) == "method=ksmea: unknown value for misfit: 'Log'; did you mean 'log'? known: log"
        assert (each.setting, each.meant) == ("method.misfit", UnknownName("value for misfit:", "Log", "log"))


def test_its_setting_stands_before_it_and_a_location_before_both():
    error = SettingError("expected a number, got 'a'", setting="samples")
    assert str(error) == "samples: expected a number, got 'a'"
    assert error.within("mine.yaml").reason == str(error)


def test_a_name_stands_for_the_setting_that_it_is_or_is_the_value_of():
    for noun, setting in (("setting", "samplse"), ("optimizer", "optimizer"), ("option of verify:", "")):
        assert unknown(noun, "samplse", ["samples"]).setting == setting
    assert unknown("setting", "mehs", ["mesh"], within="problem.").meant == UnknownName(
        "setting", "problem.mehs", "problem.mesh"
    )
