"""The unknowns beside a force that the model lacks, next to those that an identification finds without it."""

import numpy as np
import pytest

import ksmea
from ksmea.errors import SettingError
from ksmea.studies.identification_details import AUTO, location_options
from optimizers.lm import LM

FAST = {"optimizer": LM(screening=1000, starts=3), "rng": 0}
SETTINGS = {"relative": 0.05, "floor": 0.1, "kind": "complex", "noise_known": False, "mesh": 26, "route": "dense"}


@pytest.fixture(scope="module")
def rotor():
    return ksmea.load_problem("three_disk", sensors=[0.1, 0.5, 1.0], n_speed=40)


@pytest.fixture(scope="module")
def data(rotor):
    """With an unbalance on the first or third disk that the model lacks, made with twice as many elements."""
    return ksmea.synthetic_measurement(rotor, hidden=["unbalance"], rng=1, **SETTINGS)


def at(data):
    return next(position for position in (0.2, 1.0) if f"{position:g} m" in data.hidden[0].location)


@pytest.mark.slow
def test_beside_the_force_at_its_place_the_stiffnesses_are_true(rotor, data):
    result = ksmea.identify(rotor, data, unmodelled=at(data), **FAST)
    [site] = result.record.location.sites
    assert (site.kind, site.position) == ("force", at(data))
    table = result.to_frame().set_index("parameter").loc[["kxx", "kyy"]]
    for name, row in table.iterrows():
        assert row["low_beside"] < data.truth[name] < row["high_beside"]
    assert "beside it" in str(result)


@pytest.mark.slow
def test_a_force_elsewhere_is_rejected_and_no_value_stands_beside_it(rotor, data):
    elsewhere = {0.2: 1.1, 1.0: 0.1}[at(data)]
    result = ksmea.identify(rotor, data, unmodelled=elsewhere, **FAST)
    assert not result.record.location.sites
    assert np.isnan(result.to_frame()["value_beside"]).all()
    assert "Nothing that was tried" in str(result)


@pytest.mark.slow
def test_without_it_the_table_is_as_it_was(rotor, data):
    result = ksmea.identify(rotor, data, **FAST)
    assert result.record.location is None and "value_beside" not in result.to_frame()


def test_what_is_no_position_is_refused_in_one_line(rotor, data):
    with pytest.raises(SettingError, match="expected auto or the position of a site in m, got 'bearing'"):
        ksmea.identify(rotor, data, unmodelled="bearing")


def test_auto_tries_every_site_and_kind():
    assert not location_options("", 0.95)
    options = location_options(AUTO, 0.9)
    assert options.positions == [] and options.kinds == ["force", "moment", "reading"] and options.interval_level == 0.9
