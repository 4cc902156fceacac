"""Effects by how far each lowers the deviance."""

from __future__ import annotations

from bench.plan.page import Plot
from bench.reports.pages.traces import BLUE, GREY, TEAL, axis, layout
from ksmea.records.diagnosis import DiagnosisRecord, TrialRecord
from ksmea.show.diagnosis_tables import sized
from ksmea.show.text import LEAST_OF_A_DOUBLE, chance

LEAST = 0.1  # of a deviance drop on a logarithmic axis
WIDE = 50.0  # times the median that the largest is: from there on the axis is logarithmic
ROW = 24  # px
NAMED, AS_WELL, OTHER = "named", "explains the data about as well", "other effects"
KINDS = {NAMED: BLUE, AS_WELL: TEAL, OTHER: GREY}


def effect_plot(record: DiagnosisRecord, still: str = "") -> Plot:
    """A bar for the best location of each effect, with its p, ΔBIC and sizes where the pointer is."""
    best: dict[str, TrialRecord] = {}
    for trial in record.ranking:
        best.setdefault(trial.effect, trial)
    trials = sorted(best.values(), key=lambda trial: trial.deviance_drop)
    names = [f"{trial.effect} " for trial in trials]
    traces = []
    for kind, colour in KINDS.items():
        mine = [(name, trial) for name, trial in zip(names, trials) if _kind(record, trial) == kind]
        if mine:
            traces.append(
                {
                    "type": "bar", "orientation": "h", "name": kind, "marker": {"color": colour},
                    "y": [name for name, _ in mine], "x": [max(trial.deviance_drop, LEAST) for _, trial in mine],
                    "customdata": [_told(trial) for _, trial in mine],
                    "hovertemplate": "%{y}: deviance drop %{x:.4g}<br>%{customdata}<extra></extra>",
                }
            )  # fmt: skip
    drops = [max(trial.deviance_drop, LEAST) for trial in trials]
    is_wide = bool(drops) and drops[-1] > WIDE * drops[len(drops) // 2]
    made = layout("deviance drop", x_log=is_wide, bargap=0.25)
    made["yaxis"] = axis(categoryorder="array", categoryarray=names, tickmode="array", tickvals=names)
    return Plot(
        "Effects",
        "How far each effect, at its best location, lowers the deviance (−2 ln L) of the model as given; location, p, ΔBIC and size show on touch or"
        " hover. With a misfit that is large enough nearly every effect lowers it.",
        {"data": traces, "layout": made},
        still,
        height=120 + ROW * len(trials),
    )


def _kind(record: DiagnosisRecord, trial: TrialRecord) -> str:
    if trial.effect in record.named:
        return NAMED
    return AS_WELL if trial.effect in record.ambiguity_group else OTHER


def _told(trial: TrialRecord) -> str:
    said = f"{trial.location}, {chance(trial.p, LEAST_OF_A_DOUBLE)}, ΔBIC = {trial.delta_bic:.1f}"
    return "<br>".join([said, *map(sized, trial.parameters)])
