"""Plans of measurements in sentences, with the CRLBs before and after, and as tidy tables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd

from ksmea.measurement.channel import named
from ksmea.records.planning import Family, PlanningRecord, Step, Unknown, infinite_where_none
from ksmea.show.charts.planning_chart import is_without_size
from ksmea.show.text import aligned, fit_warning, stability_text
from ksmea.units import DEGREE, GRAM_MILLIMETRE, RPM

UNPLANNED = {
    "speeds": "as many spread evenly over the present band",
    "probes": "as many data by repeating the present run",
    "trial run": "repeating the present run",
    "numbers": "repeating the present run instead",
}
MOST_SPEEDS = 3  # that a headline lists
MAX_RANGES = 100  # a CRLB this many times what the search limits say is no number worth reading


def text(record: PlanningRecord, title: str = "") -> str:
    """Additions and their benefit, in sentences; below them the CRLB of each unknown."""
    lines = [title] if title else []
    lines += fit_warning(record.lack_of_fit, "the CRLBs and what is chosen by them")
    lines += [_opening(record), *(f"- {_sentence(record, family)}" for family in record.families)]
    lines += ["", _table(record), ""]
    lines += [f"note: {remark}" for remark in [*record.remarks, *_outside(record)]]
    lines += [f"note: {said}" for said in stability_text(record.stability)]
    lines.append("note: this holds near the values above; CRLBs are 1 σ of an estimate that uses all the data")
    return "\n".join(lines)


def best_addition(record: PlanningRecord) -> str:
    """The sentence on the additions that reduce most; the opening without any.

    It has no list of many speeds.
    """
    if not record.families:
        return _opening(record)
    best = max(record.families, key=lambda family: family.steps[-1].reduction_pct or 0.0)
    return _sentence(record, best, of_target=f"the CRLB of {record.target}", brief=True)


def frame(record: PlanningRecord) -> pd.DataFrame:
    """A row per addition and unknown, and one for all unknowns together where they all are the target.

    CRLBs `before`, `after` and `unplanned` in the unknown's unit after this and all earlier additions of the family,
    infinite where nothing is known; per cent are of its value, empty of an angle and of a value of 0.
    """
    return pd.DataFrame(list(_rows(record)))


def _rows(record: PlanningRecord) -> Iterator[dict[str, Any]]:
    has_numbers = any(family.candidates.number is not None for family in record.families)
    for family in record.families:
        for order, step in enumerate(family.steps, start=1):
            start = {
                "target": record.target or "all",
                "family": family.family,
                "order": order,
                "speed_rpm": _over(step.speed, RPM),
                "position_m": step.position,
                "direction": step.direction,
                "unbalance_g_mm": _over(step.magnitude, GRAM_MILLIMETRE),
                "phase_deg": _over(step.phase, DEGREE),
                **({"number": step.number} if has_numbers else {}),
            }
            crlbs = (infinite_where_none(crlb) for crlb in (record.crlb, step.crlb, step.unplanned_crlb))
            for parameter, before, after, unplanned in zip(record.parameters, *crlbs):
                unit = parameter.si_per_unit
                value = 0.0 if is_without_size(parameter) else abs(parameter.true)
                yield {
                    **start,
                    "parameter": parameter.name,
                    "unit": parameter.unit,
                    "value": parameter.true / unit,
                    "before": before / unit,
                    "after": after / unit,
                    "unplanned": unplanned / unit,
                    "before_pct": 100 * before / value if value else None,
                    "after_pct": 100 * after / value if value else None,
                    "unplanned_pct": 100 * unplanned / value if value else None,
                    "reduction_pct": _reduction(before, after),
                    "unplanned_reduction_pct": _reduction(before, unplanned),
                }
            if record.target is None:
                reductions = {
                    "reduction_pct": step.reduction_pct,
                    "unplanned_reduction_pct": step.unplanned_reduction_pct,
                }
                yield {**start, "parameter": "all", **reductions}


def _opening(record: PlanningRecord) -> str:
    unknown, target = record.unknown_with(record.crlb), record.target_unknown
    if target is None:
        undetermined = f"; the present data do not determine {', '.join(unknown)}" if unknown else ""
        return f"To know all unknowns better together{undetermined}:"
    if target.name in unknown:
        return f"To know {target.name}, which the present data do not determine:"
    return f"To know {target.name} better, its CRLB being {_of_target(record, record.crlb)} now:"


def _sentence(record: PlanningRecord, family: Family, of_target: str = "its CRLB", *, brief: bool = False) -> str:
    """Sentence on additions: 'add these 2 speeds: 900, 3610 rpm: its CRLB falls …'.

    A brief one has the range of many speeds.

    A whole example is 'add these 2 speeds: 900, 3610 rpm: its CRLB falls from 21 % to 9.8 % (−54 %). As many …: −9 %'.
    """
    last, count = family.steps[-1], len(family.steps)
    if record.target in record.unknown_with(last.crlb):
        many = f"the best {count} {family.family} leave it unknown"
        none = "no trial run makes it known" if family.family == "trial run" else many
        return f"{none}: {of_target} stays wider than the search limits"
    effect = _joint_effect if record.target is None else _effect
    planned = effect(record, last.crlb, last.reduction_pct, of_target)
    unplanned = effect(record, last.unplanned_crlb, last.unplanned_reduction_pct)
    return f"{_what(family.steps, brief=brief)}: {planned}; {UNPLANNED[family.family]}: {unplanned}"


def _effect(record: PlanningRecord, crlb: Sequence[float | None], reduction: float | None, of_target: str = "") -> str:
    """Effect of the additions on the target, in words; without its name in brief."""
    before, after = _of_target(record, record.crlb), _of_target(record, crlb)
    if record.target in record.unknown_with(crlb):
        return "still unknown"
    if record.target in record.unknown_with(record.crlb):
        subject = "it" if of_target == "its CRLB" else record.target
        return f"{subject} becomes known to {after}" if of_target else f"known to {after}"
    change = _change(reduction)
    return f"{of_target} falls from {before} to {after} ({change})" if of_target else change


def _joint_effect(
    record: PlanningRecord, crlb: Sequence[float | None], reduction: float | None, of_target: str = ""
) -> str:
    """Effect of the additions on all unknowns together, in words; without what it is of in brief."""
    still = record.unknown_with(crlb)
    determined = [name for name in record.unknown_with(record.crlb) if name not in still]
    of_what = "mean half axis of their confidence region " if of_target else ""
    axis = [] if reduction is None else [f"{of_what}{_change(reduction)}"]
    known = [f"{', '.join(determined)} become{'s' * (len(determined) == 1)} known"] if determined else []
    return ", ".join([*known, *axis]) or "CRLBs fall, but not far enough"


def _what(steps: Sequence[Step], *, brief: bool = False) -> str:
    """The additions in words."""
    speeds = sorted(step.speed for step in steps if step.speed is not None)
    if brief and len(speeds) > MOST_SPEEDS:
        return f"add {len(speeds)} speeds between {_rpm(speeds[0])} and {_rpm(speeds[-1])} rpm"
    if speeds:
        which = f"these {len(steps)} speeds:" if len(steps) > 1 else "the speed"
        return f"add {which} {', '.join(map(_rpm, speeds))} rpm"
    probes = [f"in {named(step.direction)} at {step.position:.4g} m" for step in steps if step.direction is not None]
    if probes:
        return f"add {'a probe' if len(steps) == 1 else f'{len(steps)} probes,'} {' and '.join(probes)}"
    numbers = [f"the {step.number}" for step in steps if step.number is not None]
    if numbers:
        and_more = f"{', '.join(numbers[:-1])} and " if len(numbers) > 1 else ""
        return f"measure {and_more}{numbers[-1]}, until {'they are' if and_more else 'it is'} as good as exact"
    return f"add a second run with {_trial(steps[0])}"


def _trial(step: Step) -> str:
    magnitude, phase = _over(step.magnitude, GRAM_MILLIMETRE), _over(step.phase, DEGREE)
    return f"{magnitude:.4g} g mm at {step.position:.4g} m, {phase:.4g}°"


def _rpm(speed: float) -> str:
    return f"{speed / RPM:.{0 if speed > 100 * RPM else 2}f}"


def _table(record: PlanningRecord) -> str:
    """A line per unknown: its CRLB now, with each family's choice, and with as many data without a plan."""
    head = ["unknown", "value", "CRLB now"]
    for family in record.families:
        of_family = "+ trial run" if family.family == "trial run" else f"+ {len(family.steps)} {family.family}"
        head += [of_family, "run again" if family.family == "numbers" else "without plan"]
    lines = []
    for index, parameter in enumerate(record.parameters):
        value = parameter.true / parameter.si_per_unit
        line = [parameter.name, f"{value:.4g} {parameter.unit}", _sized(record.crlb[index], parameter)]
        for family in record.families:
            last = family.steps[-1]
            line += [_sized(crlb[index], parameter) for crlb in (last.crlb, last.unplanned_crlb)]
        lines.append(line)
    return aligned(head, lines)


def _outside(record: PlanningRecord) -> list[str]:
    """A warning where speeds are to be added beyond the present band."""
    speeds = [step.speed for family in record.families for step in family.steps if step.speed is not None]
    if all(record.speed_from <= speed <= record.speed_to for speed in speeds):
        return []
    band = f"{_rpm(record.speed_from)} to {_rpm(record.speed_to)} rpm"
    return [f"some of these speeds lie outside the present {band}; study.band=[1,1] stays inside"]


def _of_target(record: PlanningRecord, crlb: Sequence[float | None]) -> str:
    """CRLB of the target, in words, from the CRLBs of all unknowns (d,), SI."""
    index = record.target_index
    return "" if index is None else _sized(crlb[index], record.parameters[index])


def _sized(crlb: float | None, parameter: Unknown) -> str:
    """A CRLB (SI) in per cent of the value; of an angle, and of a value of 0, in its unit."""
    if crlb is None or crlb > MAX_RANGES * parameter.range_sd:
        return "unknown"
    if is_without_size(parameter):
        return f"{_short(crlb / parameter.si_per_unit)} {parameter.unit}"
    return f"{_short(100 * crlb / abs(parameter.true))} %"


def _short(value: float) -> str:
    """Two digits, no exponent: 0.098, 21, 4100."""
    return f"{float(f'{value:.1e}'):.12g}"


def _change(reduction: float | None) -> str:
    """A reduction as the change of the CRLB: '−54 %', and 'to 1/250' where per cents would all read 100."""
    if reduction is None:
        return "becomes known"
    if reduction > 95:
        return f"to 1/{_short(1 / (1 - reduction / 100))}"
    if reduction < 0.05:
        return "no change"
    return f"−{reduction:.2g} %" if reduction < 10 else f"−{reduction:.0f} %"


def _reduction(before: float, after: float) -> float | None:
    """How many per cent a CRLB falls; None if what was not known at all becomes known."""
    if np.isinf(before):
        return 0.0 if np.isinf(after) else None
    return 100 * (1 - after / before)


def _over(value: float | None, unit: float) -> float | None:
    return None if value is None else value / unit
