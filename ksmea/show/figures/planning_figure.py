"""What each candidate of a plan gives by itself: a panel per family, the chosen ones marked."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ksmea.arrays import Array
from ksmea.measurement.channel import named
from ksmea.records.planning import Family, PlanningRecord, Unknown, infinite_where_none
from ksmea.show.charts.locators import plain_ticks
from ksmea.show.figures.style import OURS, PAPER, REFERENCE, ShownFigure, figure_of
from ksmea.units import DEGREE, GRAM_MILLIMETRE, RPM, SI_PER_UNIT

FAMILIES = ("speeds", "probes", "trial run")
ANGLES = SI_PER_UNIT["angle"]  # their values have no size that a CRLB could be a part of
MAX_PHASES = 8  # lines in one panel
DIRECTION_STYLES = ((OURS, "-"), ("#6a9a3b", "--"))  # of the two in which probes are considered


def plot(record: PlanningRecord, axes: Axes | None = None, *, title: str = "") -> Figure:
    """How far each candidate alone reduces the CRLB: speeds, probes over position, trial unbalances over position; the
    chosen ones are marked. Of a target that is not known yet, the CRLB with that candidate.

    Without axes a figure with a panel for each family; on given axes the first family that was considered.
    """
    if axes is not None:
        if record.families:
            family = record.families[0]
            _DRAW[family.family](axes, family, record)
            _finish(axes, record)
            axes.set_ylabel(_quantity(record), fontsize=9)
        return figure_of(axes)
    figure = ShownFigure(figsize=(8.0, 9.0), layout="constrained")
    panels = figure.subplots(len(FAMILIES), 1)
    draw_row(panels, record)
    for panel in panels[1:]:
        panel.set_ylabel(_quantity(record) if panel.axison else "", fontsize=9)
    of_what = f"{title}: " if title else ""
    figure.suptitle(f"{of_what}what each candidate gives by itself, the chosen ones marked", fontsize=11)
    return figure


def draw_row(panels: Sequence[Axes], record: PlanningRecord, title: str = "") -> None:
    """A panel for each of `FAMILIES`; the title stands above the name of what is drawn."""
    families = {family.family: family for family in record.families}
    for panel, name in zip(panels, FAMILIES):
        if name in families:
            _DRAW[name](panel, families[name], record)
            _finish(panel, record)
        else:
            panel.set_axis_off()
            panel.text(0.5, 0.5, f"no {name} considered", ha="center", fontsize=9, transform=panel.transAxes)
    label = f"{title}\n{_quantity(record)}" if title else _quantity(record)
    next((panel for panel in panels if panel.axison), panels[0]).set_ylabel(label, fontsize=9)


def is_without_size(parameter: Unknown) -> bool:
    """Whether per cent of its value say nothing: of an angle, and of a value of 0."""
    return parameter.unit in ANGLES or not parameter.true


def _is_unknown(record: PlanningRecord) -> bool:
    """Whether the target is not known yet, so that there is no reduction to show."""
    return record.target is not None and record.target in record.unknown_with(record.crlb)


def _counts_prior(record: PlanningRecord) -> bool:
    """Whether reductions have to count the choice's weak prior, as some of the unknowns are not known at all."""
    return record.target is None and None in record.crlb


def _quantity(record: PlanningRecord) -> str:
    target = record.target_unknown
    if target is None:
        return f"reduction of the mean half axis{', with prior' if _counts_prior(record) else ''} (%)"
    if not _is_unknown(record):
        return f"reduction of the CRLB of {target.name} (%)"
    return f"CRLB of {target.name} with one ({target.unit if is_without_size(target) else '%'})"


def _shown(record: PlanningRecord, family: Family) -> Array:
    """What is drawn for each candidate, nan where there is no number."""
    candidates, target = family.candidates, record.target_unknown
    if target is None and _counts_prior(record):
        return np.array(candidates.criterion_reduction_pct)
    if target is None or candidates.crlb is None or not _is_unknown(record):
        return np.array(candidates.reduction_pct, dtype=float)
    size = target.si_per_unit if is_without_size(target) else abs(target.true) / 100
    crlb = infinite_where_none(candidates.crlb)
    return np.where(np.isinf(crlb), np.nan, crlb / size)


def _draw_speeds(panel: Axes, family: Family, record: PlanningRecord) -> None:
    speed, shown = np.array(family.candidates.speed) / RPM, _shown(record, family)
    band = record.speed_from / RPM, record.speed_to / RPM
    panel.axvspan(*band, color=REFERENCE, alpha=0.08, linewidth=0, label="present band")
    panel.plot(speed, shown, color=OURS, linewidth=1.3)
    _mark(panel, speed, shown, family)
    panel.set_xlabel("added speed (rpm)")


def _draw_probes(panel: Axes, family: Family, record: PlanningRecord) -> None:
    position, shown = np.array(family.candidates.position), _shown(record, family)
    direction = np.array(family.candidates.direction)
    for name, (colour, style) in zip(dict.fromkeys(family.candidates.direction or ()), DIRECTION_STYLES):
        is_so = direction == name
        panel.plot(
            position[is_so],
            shown[is_so],
            marker=".",
            color=colour,
            linestyle=style,
            linewidth=1.3,
            label=f"in {named(name)}",
        )
    _mark(panel, position, shown, family)
    _draw_unplanned(panel, family, record, "as many data again")
    panel.set_xlabel("position of an added probe (m)")


def _draw_trial_runs(panel: Axes, family: Family, record: PlanningRecord) -> None:
    candidates, shown = family.candidates, _shown(record, family)
    position, phase = np.array(candidates.position), np.array(candidates.phase)
    phases = list(dict.fromkeys(candidates.phase or ()))[:MAX_PHASES]
    for index, value in enumerate(phases):
        blend = index / max(1, len(phases) - 1)
        colour = (0.17 + 0.6 * blend, 0.42 + 0.2 * blend, 0.64 - 0.5 * blend)  # from blue to ochre
        panel.plot(
            position[phase == value],
            shown[phase == value],
            ".-",
            color=colour,
            linewidth=1.1,
            label=f"{value / DEGREE:.4g}°",
        )
    _mark(panel, position, shown, family)
    _draw_unplanned(panel, family, record, "present run again")
    magnitude = (candidates.magnitude or (np.nan,))[0] / GRAM_MILLIMETRE
    panel.set_xlabel(f"position of a trial unbalance of {magnitude:.4g} g mm (m)")


_DRAW: dict[str, Callable[[Axes, Family, PlanningRecord], None]] = {
    "speeds": _draw_speeds,
    "probes": _draw_probes,
    "trial run": _draw_trial_runs,
}


def _mark(panel: Axes, abscissa: Array, shown: Array, family: Family) -> None:
    """Rings round the chosen candidates."""
    chosen = list(family.chosen)
    panel.plot(
        abscissa[chosen],
        shown[chosen],
        linestyle="none",
        marker="o",
        markersize=8,
        markerfacecolor="none",
        markeredgecolor=PAPER,
        markeredgewidth=1.6,
        label="chosen",
    )


def _draw_unplanned(panel: Axes, family: Family, record: PlanningRecord, label: str) -> None:
    reduction = family.steps[0].unplanned_reduction_pct
    if reduction is not None and not _is_unknown(record) and not _counts_prior(record):
        panel.axhline(reduction, color=REFERENCE, linestyle=":", label=label)


def _finish(panel: Axes, record: PlanningRecord) -> None:
    if _is_unknown(record):
        if not any(np.any(np.isfinite(np.asarray(line.get_ydata(), dtype=float))) for line in panel.get_lines()):
            panel.text(0.5, 0.5, "still unknown", ha="center", fontsize=9, transform=panel.transAxes)
            panel.set_xticks([])
            panel.set_yticks([])
            return
        panel.set_yscale("log")
        plain_ticks(panel.yaxis)
    else:
        panel.set_ylim(bottom=0, top=max(panel.get_ylim()[1], 1e-3) * 1.1)
    panel.tick_params(labelsize=8)
    panel.grid(alpha=0.25)
    panel.legend(fontsize=8, ncols=2, loc="best")
