"""Settings: documented fields whose ranges and choices are checked however the instance is made."""

import dataclasses
import pickle
import time
from dataclasses import dataclass

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.identification.direct import Direct
from ksmea.identification.ksmea import KSMEA
from ksmea.settings.settings import Settings, expected_range, setting
from optimizers.de import DE
from surrogates.kriging import Kriging

LIMITS = {"one": [0.0, 1.0]}


@dataclass(frozen=True)
class Example(Settings):
    """Every kind of field once."""

    rate: float = setting(0.5, "a rate", above=0, at_most=2)
    count: int | None = setting(None, "a count", at_least=1)
    strategy: str = setting("rand", "a strategy", choices=("rand", "best"))
    positions: list[float] = setting([0.1, 0.2], "places", unit="m", at_least=0, at_most=1)
    limits: dict[str, list[float]] = setting(LIMITS, "bounds", source="Table 1")
    flag: bool = setting(False, "a switch", at_least=1)
    free: float = setting(3.0, "a number without a range")


def message(**settings):
    """Message as the user reads it: always one line."""
    with pytest.raises(SettingError) as caught:
        Example(**settings)
    text = str(caught.value)
    assert "\n" not in text
    return text


@pytest.mark.parametrize("rate", [1e-300, 1.0, 2, 2.0, np.float64(0.5), np.float32(0.5)])
def test_values_inside_their_range_are_taken(rate):
    assert Example(rate=rate).rate == rate


@pytest.mark.parametrize(
    "settings, text",
    [
        ({"rate": 0.0}, "rate: expected a number above 0 and at most 2, got 0.0"),
        ({"rate": 2.0001}, "rate: expected a number above 0 and at most 2, got 2.0001"),
        ({"rate": float("nan")}, "rate: expected a number above 0 and at most 2, got nan"),
        ({"rate": float("inf")}, "rate: expected a number above 0 and at most 2, got inf"),
        ({"count": 0}, "count: expected a number at least 1, got 0"),
        ({"positions": [0.5, 1.5]}, "positions: expected a number at least 0 and at most 1, got 1.5"),
        ({"positions": (float("nan"),)}, "positions: expected a number at least 0 and at most 1, got nan"),
        ({"free": float("nan")}, "free: expected a number that is finite, got nan"),
        ({"free": float("-inf")}, "free: expected a number that is finite, got -inf"),
        ({"strategy": "bset"}, "unknown value for strategy: 'bset'; did you mean 'best'? known: best, rand"),
    ],
)
def test_a_refusal_names_the_field_what_was_expected_and_what_came(settings, text):
    assert message(**settings) == text


@pytest.mark.parametrize(
    "settings, text",
    [
        ({"rate": "fast"}, "rate: expected a number, got 'fast'"),
        ({"rate": None}, "rate: expected a number, got nothing"),
        ({"rate": True}, "rate: expected a number, got True"),
        ({"count": 2.5}, "count: expected a whole number or null, got 2.5"),
        ({"count": True}, "count: expected a whole number or null, got True"),
        ({"flag": 1}, "flag: expected true or false, got 1"),
        ({"strategy": 3}, "strategy: expected a text, got 3"),
        ({"positions": 0.1}, "positions: expected a list, each entry a number, got 0.1"),
        ({"positions": ["a"]}, "positions: expected a list, each entry a number, got a list"),
        ({"limits": [1.0]}, "limits: expected a mapping, each value a list, each entry a number, got a list"),
        ({"limits": {"one": 1.0}}, "limits: expected a mapping, each value a list, each entry a number, got a mapping"),
    ],
)
def test_a_value_of_another_type_is_refused_in_words(settings, text):
    assert message(**settings) == text


def test_plugins_made_by_hand_are_checked_too():
    for make, text in (
        (lambda: DE(population="many"), "population: expected a whole number, got 'many'"),
        (lambda: DE(population=5.5), "population: expected a whole number, got 5.5"),
        (lambda: Kriging(theta=["a"]), "theta: expected a list, each entry a number or null, got a list"),
        (lambda: Direct(optimizer=Kriging()), "optimizer: expected an Optimizer, got Kriging("),
        (lambda: KSMEA(Kriging(), DE(), samples=0), "samples: expected a number at least 1, got 0"),
        (lambda: KSMEA(Kriging(), DE(), samples="all"), "samples: expected a whole number, got 'all'"),
    ):
        with pytest.raises(SettingError) as caught:
            make()
        assert str(caught.value).startswith(text) and "\n" not in str(caught.value)


def test_checking_types_takes_no_time_to_speak_of():
    DE()
    started = time.perf_counter()
    for _ in range(1000):
        DE()
    assert time.perf_counter() - started < 1.0  # 10 µs each, and room for a busy machine


def test_numbers_of_numpy_are_checked_like_those_of_python():
    assert message(count=np.int64(0)).startswith("count: ")
    assert message(rate=np.float32(3.0)).startswith("rate: ")


def test_none_is_not_a_number_out_of_range():
    assert Example(count=None).count is None


def test_a_switch_is_no_number():
    assert Example(flag=False).flag is False


def test_mutable_defaults_are_not_shared():
    first, second = Example(), Example()
    first.positions.append(0.9)
    first.limits["two"] = [2.0, 3.0]
    assert second.positions == [0.1, 0.2] and set(second.limits) == {"one"} == set(LIMITS)


def test_settings_cannot_be_changed():
    with pytest.raises(dataclasses.FrozenInstanceError):
        Example().rate = 1.0


def test_a_changed_copy_is_checked_again():
    assert dataclasses.replace(Example(), rate=1.5).rate == 1.5
    with pytest.raises(SettingError, match="rate: "):
        dataclasses.replace(Example(), rate=-1.5)


def test_settings_are_values():
    assert Example(rate=1.0) == Example(rate=1.0) != Example(rate=1.1)
    assert pickle.loads(pickle.dumps(Example(count=3))) == Example(count=3)


def test_conditions_between_fields_come_after_their_ranges():
    @dataclass(frozen=True)
    class Interval(Settings):
        lower: float = setting(0.0, "lower", at_least=0)
        upper: float = setting(1.0, "upper")

        def check(self):
            if self.lower > self.upper:
                raise SettingError("lower above upper")

    with pytest.raises(SettingError, match="lower above upper"):
        Interval(lower=2.0)
    with pytest.raises(SettingError, match="lower: expected a number at least 0, got -1"):
        Interval(lower=-1.0, upper=-2.0)


def test_the_field_carries_its_documentation():
    field = {field.name: field for field in dataclasses.fields(Example)}
    assert field["positions"].metadata["unit"] == "m"
    assert field["limits"].metadata["source"] == "Table 1"
    assert field["strategy"].metadata["help"] == "a strategy"
    assert expected_range(field["rate"].metadata) == "above 0 and at most 2"
    assert expected_range(field["strategy"].metadata) == ""
