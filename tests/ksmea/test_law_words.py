"""Laws in words: direction, size, and what is known of both."""

import pytest

from ksmea.nonlinear.laws import LAWS, MOMENT_LAWS
from ksmea.records.location import LawCoefficientRecord, LawRecord
from ksmea.show.location_words import law_words


def record(law, values, sd):
    coefficients = tuple(
        LawCoefficientRecord(name, unit, value, spread)
        for (name, unit, _), value, spread in zip(law.coefficients, values, sd)
    )
    return LawRecord(law.name, 0.5, 0.3, 100.0, True, coefficients, (), law.key)


@pytest.mark.parametrize(
    "key, values, sd, words",
    [
        ("unbalance", [30.0, 40.0], [1.0, 1.0], "50.0 ± 1.0 g mm at 53.1° ± 1.1°"),
        (
            "spring",
            [2.1, 3.0],
            [0.2, 0.3],
            "it opposes the motion like a spring, k_x = 2.10 ± 0.20 MN/m, k_y = 3.00 ± 0.30 MN/m",
        ),
        ("damper", [-2.0, -1.0], [0.1, 0.1], "it feeds the motion as if a damper were missing, c_x = -2.00 ± 0.10"),
        ("cross_coupling", [0.5], [0.1], "feeds forward whirl, k_xy = 0.50 ± 0.10 MN/m"),
        (
            "spring_above_an_amplitude",
            [2.1, 9.0],
            [0.2, 1.0],
            "it opposes the motion like a spring, 2.10 ± 0.20 MN/m, only above 9.0 ± 1.0 µm",
        ),
        (
            "rub",
            [2.1, 9.0, 0.3],
            [0.2, 1.0, 0.1],
            "only above 9.0 ± 1.0 µm, with a friction coefficient of 0.30 ± 0.10",
        ),
        ("cubic_spring", [-1.0], [0.1], "a spring that softens, k₃ = -1.00 ± 0.10 MN/mm³"),
        ("rotating_asymmetry", [0.0, 2.0], [0.1, 0.1], "± 2.00 ± 0.10 MN/m at 45.0° ± 1.4°"),
        ("skew", [1e-5, 0.0], [1e-6, 1e-6], "(1.00 ± 0.10)e-05 kg m² at 0.0°"),
    ],
)
def test_a_law_is_said_with_direction_and_size(key, values, sd, words):
    assert words in law_words(record({**LAWS, **MOMENT_LAWS}[key], values, sd))


@pytest.mark.parametrize("law", [*LAWS.values(), *MOMENT_LAWS.values()], ids=lambda law: law.key)
def test_every_law_has_words_of_its_own(law):
    sizes = [1.0] * len(law.coefficients)
    assert not law_words(record(law, sizes, sizes)).startswith("it acts as constant")
    assert f"it acts as {law.name}" not in law_words(record(law, sizes, sizes))
