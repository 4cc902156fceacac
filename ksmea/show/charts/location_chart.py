"""A location: p of every site above the shaft, and over speed what acts at the best one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ksmea.arrays import Array
from ksmea.records.location import NONE, NOTHING, PAIR, ForceRecord, LocationRecord, SeriesRecord
from ksmea.show.charts.chart import Axis, Band, Chart, Element, Level, Line, Panel, Points, Words, broken
from ksmea.show.charts.colours import ALIKE, CATEGORIES, CONTEXT, MEASURED, REFERENCE
from ksmea.show.location_words import over_the_shaft
from ksmea.show.readings import deviation_unit, speed_at_pointer, speed_label, speed_unit, vibration_unit
from ksmea.show.text import LEAST_OF_A_DOUBLE, chance, number

COLOUR_OF_QUANTITY = {**dict(zip(("force", "moment", "reading", "force and moment"), CATEGORIES)), PAIR: CONTEXT}
COLOUR_OF_PART = dict(zip(("x", "y", "forward", "backward"), CATEGORIES))
MEGA = 1e6
LEAST_P = 1e-300  # of a site, drawn on a logarithmic axis
LINEAR = 1e-2  # of the largest work: below it the axis is linear
N_SD = 2.0  # of the band of a law


def location_chart(record: LocationRecord) -> Chart:
    """The shaft with the sites.

    Below it, if something was located, its amplitude, its work per turn and its dynamic stiffness over speed.
    """
    force = _located(record)
    stacks = [tuple(_shaft(record))]
    if force is not None:
        draw = (_amplitude, *((_work, _stiffness) if force.work else ()))
        stacks.append(tuple(each(record, force) for each in draw))
    return Chart(_title(record), _caption(record), tuple(stacks))


def _located(record: LocationRecord) -> ForceRecord | None:
    """The force at the best site; None if the cause is spread, as it would be one of many."""
    return None if record.is_spread else record.force


def _title(record: LocationRecord) -> str:
    if record.kind == NOTHING:
        return f"The model is enough (p = {record.plain.p:.2g}): nothing needs to be located"
    if record.kind == NONE:
        return "Nothing that was tried explains the data"
    if record.is_spread:
        return f"Something unknown explains the data, {over_the_shaft(record)}"
    places = [] if record.force is None else [f"{position:g} m" for position in record.force.positions]
    where = f": best at {' and '.join(places)}" if places else ""
    return f"An unknown {record.kind} explains the data{where}"


def _caption(record: LocationRecord) -> str:
    said = (
        "p of the test of each site over its position; filled: accepted, hollow: rejected, dashed: the level of the test. Below"
        " it the shaft with its disks, bearings and probes (triangles above it)."
    )
    force = _located(record)
    if force is None:
        return said
    said += f" Over speed the unknown {force.kind} at the best site; bands: {100 * record.interval_level:g} % intervals"
    said += f"; dashed: the law that it follows, ± {N_SD:g} σ" if _follows_law(record, force) else ""
    said += "; work above 0 feeds the motion" if force.work else ""
    shown = [each for each in force.stiffness if each.part in ("x", "y")] if force.work else []
    if shown:
        followed = ", ".join(f"{each.part} {each.coherence:.2f}" for each in shown)
        said += (
            "; the dynamic stiffness is force over motion of the site, −f/q (line: in phase, dotted: in quadrature),"
            f" what the force amounts to where it follows the motion (coherence: {followed})"
        )
    return f"{said}."


def _shaft(record: LocationRecord) -> Iterator[Panel]:
    """p of each site over its position, and below it the shaft."""
    x = Axis("position (m)", group="position")
    elements = [element for quantity in COLOUR_OF_QUANTITY for element in _sites(record, quantity)]
    elements.append(Level(at=record.level, dash="dash", width=0.8))
    if record.candidates:
        yield Panel(tuple(elements), x, Axis("p of the site", "log", high=1.6), height=2.6)
    places = record.landmarks.items()
    drawn: list[Element] = [Line(record.shaft, [0, 0], width=5.0, colour=CONTEXT, name="")]
    for symbol, is_bearing in (("triangle up", True), ("post", False)):
        mine = [(name, at) for name, at in places if name.startswith("bearing") == is_bearing]
        said = [f"{name}: {at:g} m" for name, at in mine]
        drawn.append(Points([at for _, at in mine], [0] * len(mine), symbol, 9.0, colour=ALIKE, said=said))
    probes = [*dict.fromkeys(record.planes)]
    drawn.append(Points(probes, [0.75] * len(probes), "triangle down", 6.0, colour=MEASURED, said="probe: {x:g} m"))
    drawn += [Words(x=at, y=-0.75, text=_short(name), size=7, edge="top") for name, at in places]
    yield Panel(tuple(drawn), x, Axis(low=-1.6, high=1.2, ticks={}), height=0.8)


def _short(name: str) -> str:
    """'disk 2' as 'd2', to stand below a shaft on a telephone."""
    word, _, of = name.partition(" ")
    return f"{word[:1]}{of}" if of.isdigit() else name


def _sites(record: LocationRecord, quantity: str) -> Iterator[Element]:
    sites = sorted((site for site in record.candidates if site.kind == quantity), key=lambda site: site.position)
    colour = COLOUR_OF_QUANTITY[quantity]
    if quantity == PAIR:  # from one of its places to the other
        lines = [(at, site.p) for site in sites for at in (*site.positions, np.nan)]
    else:
        lines = [(at, site.p) for site in sites for at in site.positions]
    if lines:
        x, y = np.transpose(lines)
        yield Line(x, np.maximum(y, LEAST_P), colour=colour, width=0.6, opacity=0.5)
    for is_accepted in (False, True):
        mine = [(at, site) for site in sites if site.accepted == is_accepted for at in site.positions]
        if mine:
            said = [f"{site}: {chance(site.p, LEAST_OF_A_DOUBLE)}, χ² = {number(site.chi2)}" for _, site in mine]
            at, p = [at for at, _ in mine], [max(site.p, LEAST_P) for _, site in mine]
            name = f"{quantity}, {'accepted' if is_accepted else 'rejected'}"
            yield Points(
                at, p, size=7.0 if is_accepted else 5.0, is_open=not is_accepted, name=name, colour=colour, said=said
            )


def _follows_law(record: LocationRecord, force: ForceRecord) -> bool:
    return record.law is not None and (record.law.position, record.law.kind) == (force.position, force.kind)


def _amplitude(record: LocationRecord, force: ForceRecord) -> Panel:
    unit, scale = force.parts[0].unit, 1.0
    if unit == "m":
        unit, scale = deviation_unit(record.notation), vibration_unit(record.notation)
    elements = [each for part in force.parts for each in _series(record, part.amplitude, part.part, scale)]
    if record.law is not None and _follows_law(record, force):
        for amplitude, sd in zip(record.law.amplitude, record.law.amplitude_sd):
            low, high = (_lines(record, np.array(amplitude) + sign * N_SD * np.array(sd)) for sign in (-1, 1))
            elements.append(Band(_speed(record), low, high, colour=REFERENCE))
        for direction, amplitude in zip("xy", record.law.amplitude):
            said = f"{record.law.law} ({direction}): {_said(record)}"
            line = _lines(record, amplitude)
            elements.append(Line(_speed(record), line, "dash", 1.0, name=record.law.law, colour=REFERENCE, said=said))
    return _over_speed(record, elements, Axis(f"{force.kind} ({unit})", "log"))


def _work(record: LocationRecord, force: ForceRecord) -> Panel:
    assert force.work is not None, "a force whose work is known"
    elements: list[Element] = [*_series(record, force.work, "x", name=""), Level(at=0.0, dash="solid", width=0.6)]
    linear = LINEAR * (float(np.max(np.abs(force.work.value))) or 1.0)
    return _over_speed(record, elements, Axis("work (J per turn)\nabove 0: feeds", "symlog", linear=linear))


def _stiffness(record: LocationRecord, force: ForceRecord) -> Panel:
    """In phase, and dotted in quadrature, of the parts in x and y."""
    shown = [each for each in force.stiffness if each.part in ("x", "y")]
    elements: list[Element] = [Level(at=0.0, dash="solid", width=0.6)]
    for each in shown:
        elements += _series(record, each.real, each.part, MEGA)
        quadrature = _lines(record, each.imaginary.value) / MEGA
        elements.append(
            Line(_speed(record), quadrature, "dot", 1.2, colour=COLOUR_OF_PART[each.part], said=_said(record))
        )
    values = np.concatenate([each.real.value for each in shown]) / MEGA
    low, high = np.quantile(values, [0.05, 0.95])
    margin = max(high - low, 1e-3)
    return _over_speed(record, elements, Axis("dynamic stiffness (MN/m)", low=low - margin, high=high + margin))


def _over_speed(record: LocationRecord, elements: Sequence[Element], y: Axis) -> Panel:
    return Panel(tuple(elements), Axis(speed_label(record.notation), group="speed"), y, height=1.9)


def _said(record: LocationRecord) -> str:
    """Speed and value at the pointer, to be filled in."""
    return f"{speed_at_pointer(record.notation)}: {{y:.4g}}"


def _series(
    record: LocationRecord, series: SeriesRecord, part: str, scale: float = 1.0, name: str | None = None
) -> list[Element]:
    """A quantity over speed with the band of its interval."""
    colour = COLOUR_OF_PART.get(part, REFERENCE)
    value, low, high = (_lines(record, values) / scale for values in (series.value, series.low, series.high))
    line = Line(
        _speed(record), value, width=1.2, name=part if name is None else name, colour=colour, said=_said(record)
    )
    return [Band(_speed(record), low, high, colour=colour), line]


def _speed(record: LocationRecord) -> Array:
    return _lines(record, record.speed) / speed_unit(record.notation)


def _lines(record: LocationRecord, values: Sequence[float] | Array) -> Array:
    """Values over speed, a line for each run."""
    return broken(values, record.breaks)
