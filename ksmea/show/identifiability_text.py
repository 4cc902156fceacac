"""Precision of the unknowns in sentences, and a table of it with other data."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd

from ksmea.arrays import Array
from ksmea.records.identifiability import (
    ALL_NUMBERS,
    DataDescription,
    IdentifiabilityRecord,
    Unknown,
    Value,
    percent,
)
from ksmea.show.inputs_text import origins
from ksmea.show.text import ALIKE, aligned, alike_text, fit_warning, noise_parts, stability_text, two_digits
from ksmea.units import RPM

KNOWN_PCT, IDENTIFIABLE_PCT = (
    20.0,
    100.0,
)  # half-widths up to which an unknown counts as known, and as identifiable at all
PART = 0.1  # smaller parts of a direction are not mentioned
FAR = 1e4  # %; larger half-widths are not printed: they say no more, and rounding is in them
IN_TABLE = {"numbers": "exact"}
COLUMNS = ("variation", "value", "parameter", "unit", "true", "crlb", "crlb_pct", "level", "half_width_pct")


def text(record: IdentifiabilityRecord, title: str = "", *, with_variations: bool = True) -> str:
    """Sentences on the unknowns that the data determine and the ones that they do not.

    Below them how that varies with the data.
    """
    lines = [*([title] if title else []), *fit_warning(record.lack_of_fit, "the intervals"), *sentences(record)]
    if with_variations and record.variations:
        lines += ["", variations_text(record)]
    return "\n".join(lines)


def frame(record: IdentifiabilityRecord) -> pd.DataFrame:
    """Tidy table: a row per variation, value and parameter.

    `true` and `crlb` (1 σ) in the parameter's unit, `half_width_pct` for the interval at `level`. The variation
    'present' is the data as they are.
    """
    rows = []
    for variation, value, crlbs in _cases(record):
        for parameter, crlb in zip(record.parameters, crlbs):
            pct = percent(crlb, parameter.base)
            row = (
                *(variation, value, parameter.name, parameter.unit),
                *(parameter.true / parameter.si_per_unit, crlb / parameter.si_per_unit),
                *(pct, record.level, record.sigmas * pct),
            )
            rows.append(dict(zip(COLUMNS, row)))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def finding(record: IdentifiabilityRecord) -> str:
    """The precision in a line.

    For example 'You will know 6 of 7 unknowns to ± 0.48 to 3.5 % (95 %), c1 (± 59 %) only roughly'.
    """
    known, rough, unknown = _classes(record)
    parts = []
    if known:
        every = len(known) == len(record.parameters)
        which = f"all {len(known)}" if every else f"{len(known)} of {len(record.parameters)}"
        widths = [record.sigmas * each.crlb_pct for each in known if each.base]
        ends = list(dict.fromkeys(two_digits(width) for width in (min(widths), max(widths)))) if widths else []
        to = f" to ± {' to '.join(ends)} %" if ends else ""
        parts.append(f"You will know {which} unknowns{to} ({100 * record.level:g} %)")
    if rough:
        parts.append(f"{_named(record, rough)} only roughly")
    if unknown:
        parts.append(f"{', '.join(each.name for each in unknown)} not at all")
    return ", ".join(parts)


def _named(record: IdentifiabilityRecord, unknowns: Sequence[Unknown]) -> str:
    """Names with their half-widths, if they have one in per cent: 'c1 (± 59 %)'."""
    pcts = [f" (± {two_digits(record.sigmas * each.crlb_pct)} %)" if each.base else "" for each in unknowns]
    return ", ".join(f"{each.name}{pct}" for each, pct in zip(unknowns, pcts))


def _classes(record: IdentifiabilityRecord) -> tuple[list[Unknown], list[Unknown], list[Unknown]]:
    """Unknowns that the data determine, roughly determine, and do not determine."""
    known: list[Unknown] = []
    rough: list[Unknown] = []
    unknown: list[Unknown] = []
    for each in record.parameters:
        # a value of 0 and an angle have no per cent: they are measured by the limits of their search
        range_pct = 100 * record.sigmas * each.crlb_si / (each.upper - each.lower)
        measure = record.sigmas * each.crlb_pct if each.base else range_pct
        (known if measure <= KNOWN_PCT else rough if measure <= IDENTIFIABLE_PCT else unknown).append(each)
    return known, rough, unknown


def sentences(record: IdentifiabilityRecord) -> Iterator[str]:
    """Sentences on the data, on the precision of each unknown, and on unknowns that are not identifiable."""
    yield f"With {_data_text(record.data)}"
    known, rough, unknown = _classes(record)
    if known:
        yield f"you will know ({100 * record.level:g} %): {_known_texts(record, known)}"
    if rough:
        yield f"you will know only roughly: {_known_texts(record, rough)}"
    if unknown:
        yield f"not identifiable: {_known_texts(record, unknown)}"
    pairs = alike_text(record.correlation, record.names)
    yield f"strongly correlated parameters (|r| > {ALIKE}): {pairs}"
    yield _worst_text(record)
    yield from _numbers_text(record)
    yield from stability_text(record.stability)
    yield from (f"note: {remark}" for remark in record.remarks)
    if record.data.floor == 0 and any(entry.variation == "position" for entry in record.variations):
        yield (
            "the noise has no floor, so that a probe that sees next to nothing counts as precise; if yours has one, say"
            " measurement.floor=… (µm)"
        )


def _cases(record: IdentifiabilityRecord) -> Iterator[tuple[str, str, Array]]:
    """Variation, value in words and CRLBs (d,), SI, infinite where not identifiable.

    The present data first.
    """
    yield "present", "", record.crlb_si
    for entry in record.variations:
        yield entry.variation, _value_text(entry.variation, entry.value), entry.crlb_si


def _value_text(variation: str, value: Value) -> str:
    if isinstance(value, tuple):
        return f"{value[0] / RPM:.0f}–{value[1] / RPM:.0f} rpm"
    if variation == "position":
        return f"{value:.4g} m"
    if variation == "numbers" and value == ALL_NUMBERS:
        return "all numbers"
    return f"× {value:g}" if variation == "noise" else str(value)


def _data_text(data: DataDescription) -> str:
    n_channel = len(data.channels)
    speeds = f"{data.n_speed} speeds from {data.speed_from / RPM:.0f} to {data.speed_to / RPM:.0f} rpm"
    if data.n_speed == 1:
        speeds = f"1 speed of {data.speed_from / RPM:.0f} rpm"
    channels = f"{n_channel} channel{'s' if n_channel > 1 else ''} ({', '.join(data.channels)})"
    values = {"amplitude": "amplitudes", "complex": "complex values"}[data.kind]
    unknown_level = "" if data.noise_known else " of unknown level"
    return f"{speeds}, {channels}, {values} and {noise_parts(data.relative, data.floor)} noise{unknown_level}"


def _known_texts(record: IdentifiabilityRecord, unknowns: Sequence[Unknown]) -> str:
    return ", ".join(
        _known_text(each, record.sigmas * each.crlb_si, record.sigmas * each.crlb_pct) for each in unknowns
    )


def _known_text(parameter: Unknown, half_width: float, half_width_pct: float) -> str:
    """For example 'kxx to ± 0.1 MN/m (± 0.21 %)'; the half-width is SI."""
    if half_width_pct > 1000 or not np.isfinite(half_width):
        return f"{parameter.name} (± more than 1000 %)"
    in_pct = f" (± {two_digits(half_width_pct)} %)" if parameter.base else ""
    return f"{parameter.name} to ± {capped(half_width / parameter.si_per_unit)} {parameter.unit}{in_pct}"


def _worst_text(record: IdentifiabilityRecord) -> str:
    """The direction of relative change that the data constrain least, its largest part positive."""
    change = np.array(record.worst_direction.change)
    change = change * np.sign(change[np.argmax(np.abs(change))])
    order = [index for index in np.argsort(-np.abs(change)) if abs(change[index]) >= PART]
    parts = [f"{change[index]:+.2f} {record.names[index]}" for index in order]
    crlb = record.worst_direction.crlb
    width = np.inf if crlb is None else 100 * record.sigmas * crlb
    known = "not at all" if width > 1000 else f"to ± {two_digits(width)} %"
    return f"least constrained: a joint relative change of {' '.join(parts)}, known {known}"


def _numbers_text(record: IdentifiabilityRecord) -> Iterator[str]:
    """Sentences on numbers that are known to a tolerance, and their shares in the CRLBs."""
    if record.numbers:
        count = len(record.numbers)
        many = f"{count} numbers that are" if count > 1 else "1 number that is"
        yield f"these intervals allow for {many} known to a tolerance:"
        yield from (f"  {line}" for line in origins(record.parameters))


def variations_text(record: IdentifiabilityRecord) -> str:
    """Half-widths in per cent; for a true value of 0 and an angle in its unit.

    A star marks the data as they are.
    """
    units = ["%" if parameter.base else parameter.unit for parameter in record.parameters]
    present = set(_present(record.data))
    lines, before = [], None
    unseen = {_value_text(entry.variation, entry.value) for entry in record.least_variations}
    for variation, value, crlbs in _cases(record):
        if variation == "numbers" and value in unseen:
            continue
        widths = [
            record.sigmas * (percent(crlb, parameter.base) if parameter.base else crlb / parameter.si_per_unit)
            for parameter, crlb in zip(record.parameters, crlbs)
        ]
        first = IN_TABLE.get(variation, variation) if variation != before else ""
        star = " *" if variation != "present" and f"{variation} {value}" in present else "  "
        lines.append([first, value + star, *map(capped, widths)])
        before = variation
    head = ["±", f"{100 * record.level:g} %  ", *(f"{name} {unit}" for name, unit in zip(record.names, units))]
    notes = ["* the data as they are"] if any(line[1].endswith("*") for line in lines) else []
    if unseen:
        count, others = len(unseen), len(unseen) < len(record.numbers)
        many = f"{count} numbers" if count > 1 else "1 number"
        notes.append(f"{many} {'more ' if others else ''}would narrow no interval by 1 % if exact")
    return "\n".join([aligned(head, lines), *notes])


def _present(data: DataDescription) -> Iterator[str]:
    """Value of each variation in the data as they are, in words."""
    yield f"speeds {data.n_speed}"
    yield f"band {_value_text('band', (data.speed_from, data.speed_to))}"
    if len(data.positions) == 1:
        yield f"position {_value_text('position', data.positions[0])}"
    yield f"noise {_value_text('noise', 1.0)}"
    yield f"kind {data.kind}"


def capped(value: float) -> str:
    """Two digits, whole from 100 on; '∞' and '> 10⁴' where more would say nothing."""
    if not value <= FAR:
        return "> 10⁴" if np.isfinite(value) else "∞"
    return two_digits(value)
