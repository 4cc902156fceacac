"""Text of numbers and columns, and the sentences that several texts share.

They are on strongly correlated unknowns, the Hausman test, hidden effects, lack of fit, predictive gain, repeats and stability.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd

from ksmea.measurement.notation import LEAD, Notation
from ksmea.records.campaign import BothWaysRecord, RepeatsRecord
from ksmea.records.estimate import NoiseLevelRecord, StabilityRecord
from ksmea.records.extension import PredictiveGainRecord
from ksmea.records.hidden import HiddenEffect
from ksmea.records.identification import LackOfFit
from ksmea.show.readings import PLAIN, deviation_unit, speed_digits, speed_unit, vibration_unit

SMALLEST = 1e-15  # p that is told: rounding
LEAST_OF_A_DOUBLE = 1e-300
MOST_DECIMALS = 9  # of a value with its interval
WRITTEN_OUT = 1e12  # from where on such values are not
MOST_DIGITS = 15  # of a double
PLAIN_DECIMALS = 6  # of a value with its error; of more, and from `LARGEST` on, both are written with a power of ten
LARGEST = 1e7
LEAST_WHOLE = 99.5  # from where on two digits are written as a whole number
ONE_SIDED_DIGITS = 4  # of a value alone; at most beside one end, which may be near a value that is not well known


def aligned(head: list[str], lines: list[list[str]]) -> str:
    """Columns of text, right-aligned."""
    widths = [max(len(line[column]) for line in [head, *lines]) for column in range(len(head))]
    return "\n".join("  ".join(text.rjust(width) for text, width in zip(line, widths)) for line in [head, *lines])


def in_columns(table: pd.DataFrame) -> str:
    """A table of texts for a terminal."""
    return aligned([*map(str, table.columns)], table.to_numpy().tolist())


def number(value: Any, digits: int = 4, sign: str = "") -> str:
    """A number to so many digits.

    One of more places than that up to seven is written out, '–' stands for none.

    >>> number(49361.7, 3), number(9999.6), number(2.5e9), number(1.5), number(None)
    ('49400', '10000', '2.5e+09', '1.5', '–')
    """
    if pd.isna(value):
        return "–"
    rounded = float(f"{value:.{digits}g}")
    if 10**digits <= abs(rounded) < LARGEST:
        return f"{rounded:{sign}.0f}"
    return f"{value:{sign}.{digits}g}"


def with_ends(value: float, low: float | None, high: float | None) -> str:
    """A value with the ends of its interval, rounded by `rounded_alike`.

    >>> with_ends(2006.4, 1990.6, 2022.1), with_ends(0.50662, 0.47401, None), with_ends(500, 500, None)
    ('2006 [1991, 2022]', '0.507 [0.474, –]', '500.0 [500.0, –]')
    """
    return " ".join(value_and_ends(value, low, high))


def value_and_ends(value: float, low: float | None, high: float | None) -> tuple[str, str]:
    """A value and its interval, rounded by `rounded_alike`, in two columns."""
    at, *ends = rounded_alike(value, low, high)
    return at, f"[{', '.join(ends)}]"


def rounded_alike(*values: float | None) -> list[str]:
    """A value and the ends of its interval, all of them with the same decimals.

    A value that is missing or not finite is '–'.

    - Both ends: as many decimals as show half the width to two digits.
    - One end: as many as show half the distance to it to two digits, but no more than give the larger one four digits.
    - None: as many as give the value four digits.
    - Where one of them would be left with less than two digits by that, each is written by itself, to as many digits as the
      largest would have, three or more.

    >>> rounded_alike(1.0, 0.9999858, None), rounded_alike(500.0, 499.9, None)
    (['1.000', '1.000', '–'], ['500.0', '499.9', '–'])
    >>> rounded_alike(50.0, 12.34, None), rounded_alike(50.0, None, None)
    (['50', '12', '–'], ['50.00', '–', '–'])
    >>> rounded_alike(0.04, 0.0004, 12), rounded_alike(1000, 5, 1e6)
    (['0.04', '0.0004', '12'], ['1000', '5', '1000000'])
    >>> rounded_alike(1e-10, 9e-11, 1.1e-10), rounded_alike(15041000, 14998000, 15084000)
    (['1e-10', '9e-11', '1.1e-10'], ['15041000', '14998000', '15084000'])
    """
    finite = [value for value in values if value is not None and np.isfinite(value)]
    sizes = [abs(value) for value in finite if value] or [1.0]
    half = (max(finite) - min(finite)) / 2 if finite else 0.0
    largest = int(np.floor(np.log10(max(sizes))))
    alone = max(ONE_SIDED_DIGITS - 1 - largest, 0)
    places = alone if not half else min(_places(half), alone) if len(finite) < len(values) else _places(half)
    alike = places <= MOST_DECIMALS and max(sizes) < WRITTEN_OUT and min(sizes) >= 10.0 ** (1 - places)
    digits = int(np.clip(largest + places + 1, 3, MOST_DIGITS))
    return [
        "–" if value is None or not np.isfinite(value) else fixed(value, places) if alike else number(value, digits)
        for value in values
    ]


def with_error(value: float, error: float, sign: str = "") -> str:
    """A value with its standard error, which has two digits; the value ends at the same place.

    `sign` '+' shows the sign of a positive value.

    >>> with_error(4936.2, 4804.1, "+"), with_error(2.0951, 0.2), with_error(2.4512e9, 2.04e8)
    ('+4900 ± 4800', '2.10 ± 0.20', '(2.45 ± 0.20)e+09')
    """
    if not (np.isfinite(value) and np.isfinite(error) and error > 0):
        return f"{number(value, 3, sign)} ± {number(error, 2)}"
    power = int(np.floor(np.log10(max(abs(value), error))))
    if _is_plain(value, error):
        places = _places(error)
        return f"{fixed(value, places, sign)} ± {fixed(error, places)}"
    places = _places(error / 10.0**power)
    return f"({fixed(value / 10.0**power, places, sign)} ± {fixed(error / 10.0**power, places)})e{power:+03d}"


def angle_with_error(angle: float, error: float) -> str:
    """An angle in degrees with its standard error, never with a power of ten.

    >>> angle_with_error(53.13, 1.2), angle_with_error(53.13, 0.0)
    ('53.1° ± 1.2°', '53.13° ± 0°')
    """
    if not (np.isfinite(angle) and np.isfinite(error) and error > 0):
        return f"{number(angle)}° ± {number(error, 2)}°"
    places = min(_places(error), MOST_DECIMALS)
    return f"{fixed(angle, places)}° ± {fixed(error, places)}°"


def fixed(value: float, places: int, sign: str = "") -> str:
    """A value rounded to a number of decimals, which may be below 0.

    >>> fixed(4936.2, -2), fixed(0.5, 3), fixed(-0.01, 1)
    ('4900', '0.500', '0.0')
    """
    rounded = round(value, places)
    return f"{0.0 if rounded == 0 else rounded:{sign}.{max(places, 0)}f}"


def _places(error: float) -> int:
    """Decimals of the second digit of a number, once it is rounded to two."""
    return 1 - int(np.floor(np.log10(float(f"{error:.1e}"))))


def _is_plain(value: float, error: float) -> bool:
    return max(abs(value), error) < LARGEST and _places(error) <= PLAIN_DECIMALS


def data_words(
    n_speed: int,
    speed_from: float,
    speed_to: float,
    channels: Sequence[str],
    notation: Notation = PLAIN,
    *,
    with_phase: bool,
) -> str:
    """Measured speeds (rad/s), channels and kind in words; leads and µm go without saying."""
    low, high = (speed_digits(end / speed_unit(notation), notation) for end in (speed_from, speed_to))
    amplitudes = notation.detection if notation.unit == PLAIN.unit else notation.unit
    phases = " and phases" + ("" if notation.phase == LEAD else f" ({notation.phase})")
    return (
        f"{n_speed} speeds from {low} to {high} {notation.speed},"
        f" {len(channels)} channel{'s' if len(channels) > 1 else ''} ({', '.join(map(notation.name, channels))}),"
        f" amplitudes ({amplitudes}){phases if with_phase else ''}"
    )


def noise_parts(relative: float, floor: float, notation: Notation = PLAIN) -> str:
    """For example '4.6 % + 0.017 µm', a part that is 0 left out."""
    parts = [f"{two_digits(100 * relative)} %"] if relative else []
    parts += [f"{two_digits(floor / vibration_unit(notation))} {deviation_unit(notation)}"] if floor else []
    return " + ".join(parts) or "none"


def noise_level(level: NoiseLevelRecord, notation: Notation = PLAIN) -> str:
    """Noise level in words: '5 % of each value and 0.1 µm', or the level of each run that has its own.

    A relative part of 0 and a floor below 1 nm, which no probe resolves, are left out.
    """
    if not level.by_run:
        return _level(level.relative, level.floor, notation)
    return "; ".join(f"run {name} {_level(relative, floor, notation)}" for name, relative, floor in level.by_run)


def _level(relative: float, floor: float, notation: Notation) -> str:
    parts = [f"{100 * relative:.3g} % of each value"] if relative else []
    parts += (
        [f"{floor / vibration_unit(notation):.3g} {deviation_unit(notation)}"]
        if floor >= LEAST_FLOOR or (not parts and floor)
        else []
    )
    return " and ".join(parts) or "none"


def chance(p: float, least: float = SMALLEST) -> str:
    """For example 'p = 0.012'; 'p < …' if it is not above `least`."""
    return f"p = {p:.2g}" if not p <= least else f"p < {least:g}"


def of_chances(p: float) -> str:
    """A p in a column of them; '< 1e-300' if it is too small for a double.

    >>> of_chances(9.5e-89), of_chances(0.0)
    ('9.5e-89', '< 1e-300')
    """
    return f"{p:.2g}" if not p <= LEAST_OF_A_DOUBLE else f"< {LEAST_OF_A_DOUBLE:g}"


def two_digits(value: float) -> str:
    """Two digits, whole from 100 on.

    >>> two_digits(99.6), two_digits(1234.5), two_digits(0.0171)
    ('100', '1234', '0.017')
    """
    return f"{value:.2g}" if abs(value) < LEAST_WHOLE else f"{value:.0f}"


LEAST_FLOOR = 1e-9  # m of a noise floor in words
ALIKE = 0.95  # |correlation| above which two unknowns are strongly correlated
MAX_PAIRS = 6  # of them that are named


def alike_text(correlation: Sequence[Sequence[float | None]], names: Sequence[str]) -> str:
    """For example 'kxx and kyy (+0.971)'; 'none' without such pairs."""
    pairs = [
        f"{names[one]} and {names[other]} ({value:+.3f})"
        for one, row in enumerate(correlation)
        for other, value in enumerate(row)
        if other > one and value is not None and abs(value) > ALIKE
    ]
    more = f" and {len(pairs) - MAX_PAIRS} pairs more" if len(pairs) > MAX_PAIRS else ""
    return (", ".join(pairs[:MAX_PAIRS]) or "none") + more


DISAGREE = 0.01  # p below which it is said


def hausman_lines(record: BothWaysRecord | None) -> Iterator[str]:
    """One line; none where differences between runs show nothing."""
    if record is None or (record.p >= DISAGREE and not record.shows_machine):
        return
    if record.p >= DISAGREE:
        yield f"joint and by differences between runs agree ({chance(record.p)})"
        return
    moved = ", ".join(
        f"{each.name} by {number(abs(each.standard_errors), 2)} standard errors to {number(each.value)} {each.unit}"
        for each in record.moved
    )
    if not record.shows_machine:
        yield (
            f"runs differ by more than the model says ({chance(record.p)}): none carried a known weight, so that their differences"
            " show the sweep of the speed, or a change between runs, and nothing else of the machine: +experiment=diagnose tries a"
            " sweep if the runs have a direction or time_s; a run with a known weight would show more"
        )
        return
    yield (
        f"joint and by differences between runs do not agree ({chance(record.p)}): differences move {moved or 'several a little'};"
        " something alike in all runs, such as runout or a bow, is likely and not in the model: +experiment=diagnose looks for"
        " it, measurement.reference leaves it out"
    )


HIDDEN_COLUMN = "hidden_values"  # of tables


def hidden_in_one_line(hidden: Sequence[HiddenEffect]) -> str:
    """Effects with their locations and values, for a field of a table."""
    return "; ".join(map(str, hidden))


def hidden_text(hidden: Sequence[HiddenEffect | str], study: str) -> str:
    """Hidden effects below a heading, a line each; empty if nothing is hidden.

    `study` is the study that did not see them.
    """
    return (
        "\n  ".join([f"Hidden in these synthetic data (not seen by the {study}):", *map(str, hidden)]) if hidden else ""
    )


def fit_verdict(test: LackOfFit) -> str:
    """Whether the residuals of the model are consistent with noise."""
    if test.rejected:
        return f"{fit_rejection(test)}; +experiment=diagnose looks for the cause"
    return f"fit: the residuals are consistent with noise {_fit_evidence(test)}"


def fit_rejection(test: LackOfFit) -> str:
    """Sentence on a rejected fit, with the evidence."""
    return f"the model does not fit: its residuals are not noise {_fit_evidence(test)}"


def fit_warning(test: LackOfFit | None, made_of_it: str) -> Iterator[str]:
    """Warning that `made_of_it` rests on a rejected fit; empty if the fit is accepted or was not tested."""
    if test is not None and test.rejected:
        yield (
            f"warning: {fit_rejection(test)}, so {made_of_it} below are results of a wrong model and may mislead; run"
            " +experiment=diagnose first"
        )


def _fit_evidence(test: LackOfFit) -> str:
    return f"({test.statistic}, p = {test.p:.2g})"


def gain_lines(gain: PredictiveGainRecord, notation: Notation = PLAIN) -> list[str]:
    """Whether left-out data support the extension, and by how much."""
    supported = "supported" if gain.is_supported else "not supported"
    tests = f"sign test p = {gain.p_sign:.2g}, signed-rank p = {gain.p_wilcoxon:.2g}"
    blocks = f"it predicts {gain.n_better} of {len(gain.by_block)} blocks of speeds better ({tests})"
    in_all = with_error(gain.elpd_difference, gain.standard_error, "+")
    elpd = f"{number(gain.median, 3, '+')} in the median block and {in_all} in all"
    unit = vibration_unit(notation)
    rmse = f"{gain.rmse_before / unit:.3g} to {gain.rmse_after / unit:.3g} {deviation_unit(notation)}"
    return [
        f"The extension is {supported} by left-out data: {blocks}.",
        f"Its elpd difference is {elpd}; the rms error goes from {rmse}.",
    ]


DIFFER = 0.01  # p below which runs that are alike are said to differ


def repeat_lines(record: RepeatsRecord | None, notation: Notation = PLAIN) -> Iterator[str]:
    """For example 'repeats differ by 0.4 % + 0.1 µm (86 degrees of freedom)', and whether runs do by more."""
    if record is None:
        return
    who = "runs with the same weights" if record.are_runs else "repeats"
    level = noise_parts(record.relative, record.floor, notation)
    said = f"{who} differ by {level} ({record.degrees} degrees of freedom)"
    between = record.between
    if between is None:
        yield said
    elif between.p >= DIFFER:
        yield f"{said}; runs with the same weights differ no more than that ({chance(between.p)})"
    else:
        times = number(np.sqrt(between.ratio), 2)
        most = ", ".join(f"{each.what} ({number(np.sqrt(each.ratio), 2)} times)" for each in record.standing_out)
        where = f": {most}" if most else ""
        yield f"{said}; runs with the same weights differ {times} times as much ({chance(between.p)}){where}"


def stability_text(record: StabilityRecord | None, notation: Notation = PLAIN) -> Iterator[str]:
    """Stability threshold with its interval; empty if the problem has no growth rate."""
    if record is None:
        return
    level, above = f"{100 * record.level:g} %", f"{_speed(record.searched, notation)}, the highest speed checked"
    if record.threshold is None:
        perhaps = "" if record.low is None else f", but perhaps from {_speed(record.low, notation)} on ({level})"
        yield f"stability: no instability up to {above}{perhaps}"
        return
    high = f"above {above}" if record.high is None else _speed(record.high, notation)
    ends = f"{_speed(record.low, notation)} to {high}"
    yield f"stability: unstable from {_speed(record.threshold, notation)} on, {level} interval {ends}"
    if record.is_violated:
        yield "warning: no steady-state response exists above that speed; a machine that runs there differs from this model"


def _speed(speed: float | None, notation: Notation) -> str:
    return f"{speed_digits(speed / speed_unit(notation), notation)} {notation.speed}" if speed else "rest"


def capital(text: str) -> str:
    """The text with a capital letter first."""
    return f"{text[:1].upper()}{text[1:]}"
