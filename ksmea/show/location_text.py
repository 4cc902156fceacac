"""Text of a location: where something acts that the model lacks, its action, and the unknowns."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ksmea.records.estimate import EstimateRecord
from ksmea.records.location import (
    NONE,
    NOTHING,
    UNSEEN,
    ForceRecord,
    LawRecord,
    LocationRecord,
    SeriesRecord,
    SiteRecord,
    StiffnessRecord,
)
from ksmea.show.charts.location_chart import location_chart
from ksmea.show.charts.picture import drawn
from ksmea.show.location_words import landmarks, law_words, over_the_shaft, place, spread
from ksmea.show.readings import speed_digits, speed_unit, vibration_unit
from ksmea.show.text import aligned, capital, gain_lines, in_columns, noise_level, number, of_chances, value_and_ends

__all__ = ["frame", "plot", "text"]

MAX_LISTED = 8  # sites that the text lists
CLEARLY = 3.0  # times one part of the whirl must be as large as the other for it to be said
FOLLOWS = 0.9  # coherence from which a force is said to follow the motion of its site
MAX_RIVALS = 5
MEGA = 1e6
OVER_SITES = 'those "over all sites"'  # of the unknowns beside what is unknown, in words
CHANNELS_OF_PAIR = 5  # two forces take four complex numbers at each speed


def plot(record: LocationRecord, axes: Axes | None = None) -> Figure:
    """The shaft with the sites and what acts at the best one; on given axes the sites alone."""
    return drawn(location_chart(record), axes)


def text(record: LocationRecord) -> str:
    """The location as an engineer would say it."""
    remarks = [f"Note: {remark}" for remark in record.remarks]
    return "\n\n".join([_plain(record), *findings(record), *remarks])


def findings(record: LocationRecord) -> list[str]:
    """Paragraphs on the site, action, law and its gain, and the unknowns fitted with it."""
    return [*findings_without_values(record), *coefficients(record)]


def findings_without_values(record: LocationRecord) -> list[str]:
    """`findings` without the unknowns.

    Of a spread cause they lack the force at its best site, which is one of many.
    """
    gain = "" if record.predictive_gain is None else "\n".join(gain_lines(record.predictive_gain, record.notation))
    if record.is_spread:
        return [block for block in (where(record), _laws_if_local(record), gain) if block]
    return [block for block in (where(record), _what_it_does(record), _laws(record), gain) if block]


def about_extension(record: LocationRecord) -> list[str]:
    """Head of the file of the extended model: the law, its place and its coefficients."""
    extension, law = record.extension, record.law
    if extension is None or law is None:
        return []
    added = [name for name in extension.values if name not in {each.name for each in record.coefficients}]
    return [
        f"This file holds {law.law} at {place(record, law.position)}, fitted to a measurement:",
        *(f"  {name} = {number(extension.values[name])} {extension.units[name]}" for name in added),
    ]


def frame(record: LocationRecord) -> pd.DataFrame:
    """A row per site and kind that was tried, the accepted ones first."""
    return pd.DataFrame(
        [
            {
                "kind": site.kind,
                "position_m": site.position,
                "second_m": site.second,
                "at": landmarks(record, site),
                "p": site.p,
                "chi2": site.chi2,
                "data_left": site.n_left,
                "accepted": site.accepted,
            }
            for site in record.candidates
        ],
        columns=["kind", "position_m", "second_m", "at", "p", "chi2", "data_left", "accepted"],
    )


def _plain(record: LocationRecord) -> str:
    said = "known" if record.noise_known else "estimated"
    noise = noise_level(record.noise, record.notation)
    is_enough = record.kind == NOTHING
    lines = [
        f"The residuals are consistent with noise (p = {record.plain.p:.2g}): nothing needs to be located."
        if is_enough
        else f"The model does not fit: its residuals are not noise (p = {record.plain.p:.2g}).",
        f"Noise ({said}{'' if record.noise_known else ' where least is needed'}): {noise}.",
    ]
    return "\n".join(lines)


def where(record: LocationRecord) -> str:
    if record.kind == NOTHING:
        return ""
    if record.kind == NONE:
        tried = ", ".join(dict.fromkeys(sorted(site.kind for site in record.candidates)))
        said = f"Nothing that was tried explains the data ({tried}): the cause is spread, or there are several."
        more = _more_channels(record)
        return f"{said}{more} The nearest:\n\n{_table(record, record.candidates)}"
    quantities = dict.fromkeys(site.kind for site in record.sites)
    lines = _shares(record, quantities) if record.is_spread else _places(record, quantities)
    return "\n".join([*lines, "", _table(record, record.sites)])


def _places(record: LocationRecord, quantities: Iterable[str]) -> list[str]:
    lines = [
        f"{capital(_a(quantity))} that is free at every speed explains the data {spread(record, quantity)}."
        for quantity in quantities
    ]
    return [*lines, "These data do not tell which of them it is."] if len(lines) > 1 else lines


def _shares(record: LocationRecord, quantities: Iterable[str]) -> list[str]:
    """Shares of the places that explain the data instead of their list."""
    likely = "damping or stiffness of the whole shaft is as likely as something at one place"
    shares = [
        f"{capital(_a(quantity))} that is free at every speed explains the data at {100 * record.share(quantity):.0f} % of the places tried."
        for quantity in quantities
    ]
    return [f"Its cause is {over_the_shaft(record)}: {likely}.", *shares]


def _more_channels(record: LocationRecord) -> str:
    """Number of channels needed to try forces at two places."""
    if record.n_channel is None or record.n_channel >= CHANNELS_OF_PAIR:
        return ""
    return f" Forces at two places take data of {CHANNELS_OF_PAIR} channels or more, these have {record.n_channel}."


def sites_table(record: LocationRecord, sites: Sequence[SiteRecord]) -> pd.DataFrame:
    """A row per site, as text and pages show it."""
    rows = [
        [
            site.kind,
            " and ".join(f"{position:.4g}" for position in site.positions),
            landmarks(record, site) or "–",
            of_chances(site.p),
            number(site.chi2),
            str(site.n_left),
        ]
        for site in sites
    ]
    return pd.DataFrame(rows, columns=["kind", "m", "at", "p", "χ²", "real data left"])


def _table(record: LocationRecord, sites: Sequence[SiteRecord]) -> str:
    more = f"\n(and {len(sites) - MAX_LISTED} more)" if len(sites) > MAX_LISTED else ""
    return in_columns(sites_table(record, sites[:MAX_LISTED])) + more


def _what_it_does(record: LocationRecord) -> str:
    force = record.force
    if force is None:
        return ""
    parts = {part.part: part.amplitude for part in force.parts}
    unit, scale, detection = force.parts[0].unit, 1.0, "0-peak"
    if unit == "m":
        notation = record.notation
        unit, scale, detection = notation.amplitude, vibration_unit(notation), notation.detection
    sizes = ", ".join(
        f"{name} {_range(amplitude, scale)} {unit}" for name, amplitude in parts.items() if name not in WHIRL
    )
    said = f"{detection}, at the middle half of the speeds"
    lines = [f"At {place(record, *force.positions)} the {force.kind} is {sizes} ({said}){_whirl(parts)}."]
    lines += _hidden_unknowns(record)
    lines += _work(record, force)
    lines += [_following(stiffness) for stiffness in _followed(force)]
    return "\n".join(lines)


WHIRL = ("forward", "backward")


def _whirl(parts: Mapping[str, SeriesRecord]) -> str:
    if not set(WHIRL) <= set(parts):
        return ""
    forward, backward = (_size(parts[name]) for name in WHIRL)
    if max(forward, backward) < CLEARLY * min(forward, backward):
        return ", forward and backward alike"
    return f", mostly {WHIRL[0] if forward > backward else WHIRL[1]}"


def _size(series: SeriesRecord) -> float:
    """Root mean square over speed, each speed as it is known."""
    weight = 1 / (np.array(series.high) - series.low) ** 2
    return float(np.sqrt(np.average(np.square(series.value), weights=weight)))


def _work(record: LocationRecord, force: ForceRecord) -> list[str]:
    if force.work is None:
        return []
    feeds, takes = np.array(force.work.low) > 0, np.array(force.work.high) < 0
    n = len(feeds)
    said = [
        f"It {verb} the motion at {int(which.sum())} of {n} speeds, {_at_most(record, force.work, which)}."
        for verb, which in (("feeds", feeds), ("takes energy from", takes))
        if which.any()
    ]
    return said or ["Whether it feeds the motion or takes energy from it is not certain at any speed."]


def _at_most(record: LocationRecord, work: SeriesRecord, which: NDArray[np.bool_]) -> str:
    largest = int(np.argmax(np.where(which, np.abs(work.value), -1.0)))
    speed = speed_digits(record.speed[largest] / speed_unit(record.notation), record.notation)
    return f"at most {abs(work.value[largest]):.2g} J per turn at {speed} {record.notation.speed}"


def _followed(force: ForceRecord) -> list[StiffnessRecord]:
    """Pair of parts of the force, x and y or forward and backward, that follows the motion most, or empty."""
    following = [each for each in force.stiffness if each.coherence >= FOLLOWS]
    pairs = [[each for each in following if (each.part in WHIRL) == is_whirl] for is_whirl in (False, True)]
    return max(pairs, key=lambda pair: sum(each.coherence for each in pair))


def _hidden_unknowns(record: LocationRecord) -> list[str]:
    """Unknowns that act at the best site themselves."""
    names = [each.name for each in record.coefficients if each.best is not None and each.best.interval == UNSEEN]
    one = "it is" if len(names) == 1 else "they are"
    return (
        [f"The data cannot tell it from {' and '.join(names)} there: {one} set to where it is least."] if names else []
    )


def _following(stiffness: StiffnessRecord) -> str:
    real, imaginary = (_range(part, MEGA) for part in (stiffness.real, stiffness.imaginary))
    said = f"In {stiffness.part} it follows the motion of its site (coherence {stiffness.coherence:.2f}) as a dynamic stiffness:"
    return f"{said} {real} MN/m in phase, {imaginary} MN/m in quadrature."


def _range(series: SeriesRecord, scale: float) -> str:
    """The middle half of the values over speed."""
    low, high = np.quantile(np.array(series.value) / scale, [0.25, 0.75])
    return f"{low:.3g} to {high:.3g}"


def _laws(record: LocationRecord) -> str:
    """The law that it follows, and what other laws would do as well."""
    if not record.laws:
        return ""
    best = record.law
    if best is None:
        near = record.laws[0]
        return f"It follows none of the simple laws; the nearest: {near.law} at {place(record, near.position)} (p = {near.p:.2g})."
    lines = [f"{capital(_law(record, best))} (p = {best.p:.2g})."]
    _, *alike = record.law_class
    if alike:
        more = f" (and {len(alike) - MAX_RIVALS} more)" if len(alike) > MAX_RIVALS else ""
        lines.append(f"The data cannot tell this from:{more}")
        lines += [f"- {_law(record, law)}" for law in alike[:MAX_RIVALS]]
    return "\n".join(lines)


def _laws_if_local(record: LocationRecord) -> str:
    """The law that holds, for the case that the cause is not spread after all."""
    return "" if record.law is None else f"If it acts at one place alone:\n{_laws(record)}"


def _law(record: LocationRecord, law: LawRecord) -> str:
    return f"at {place(record, law.position)}, {law_words(law)}"


def why_without(others: str, trusted: str = OVER_SITES) -> str:
    """Why the unknowns without the force differ from the `others` of the same model, and which to trust."""
    return (
        f'The values "without" are not {others}: both are fits of the same model, but here the best site says how much each datum'
        f" weighs, and a wrong model has other values under other weights. Trust neither, but {trusted}."
    )


def coefficients(record: LocationRecord) -> list[str]:
    """The table of unknowns fitted with the unknown force and without it; empty if nothing is located."""
    if record.force is None or record.is_spread:
        return []
    level = f"{100 * record.interval_level:g} %"
    head = ["unknown", "unit", "beside it", level, f"{level} over all sites", "without"]
    lines = [
        [
            *(each.name, each.plain.unit),
            *[*_interval(each.best), *_interval(each.over_sites)[1:]],
            number(each.plain.value),
        ]
        for each in record.coefficients
    ]
    return [aligned(head, lines)]


def _interval(estimate: EstimateRecord | None) -> list[str]:
    if estimate is None:
        return ["–", "–"]
    if estimate.low is None and estimate.high is None:
        return ["–", "not known"]
    return [*value_and_ends(estimate.value, estimate.low, estimate.high)]


def _a(quantity: str) -> str:
    return f"an unknown {quantity}"
