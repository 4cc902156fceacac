"""Effects by ΔBIC, as the text, the table and the figure rank them."""

from __future__ import annotations

from bench.plan.page import Plot
from bench.reports.plots.traces import BLUE, GREY, TEAL, SymlogAxis, axis, layout
from ksmea.records.diagnosis import DiagnosisRecord, TrialRecord
from ksmea.show.diagnosis_tables import sized
from ksmea.show.figures.effect_ranking import AS_WELL, LINEAR, NAMED, OTHER, best_trials, standing
from ksmea.show.text import LEAST_OF_A_DOUBLE, chance

FEW = 2  # powers of ten beside the axis on a narrow page
ROW = 24  # px
COLOURS = {NAMED: BLUE, AS_WELL: TEAL, OTHER: GREY}
AXIS = SymlogAxis(LINEAR)  # of the figure


def effect_plot(record: DiagnosisRecord, still: str = "") -> Plot:
    """A bar for the best location of each effect, with its p, ΔBIC and sizes where the pointer is."""
    trials = best_trials(record)[::-1]
    names = [f"{trial.effect} " for trial in trials]
    traces = []
    for rank, colour in COLOURS.items():
        mine = [(name, trial) for name, trial in zip(names, trials) if standing(record, trial.effect) == rank]
        if mine:
            traces.append(
                {
                    "type": "bar", "orientation": "h", "name": rank, "marker": {"color": colour},
                    "y": [name for name, _ in mine], "x": AXIS.positions([trial.delta_bic for _, trial in mine]),
                    "customdata": [_hover_text(trial) for _, trial in mine],
                    "hovertemplate": "%{y}: %{customdata}<extra></extra>",
                }
            )  # fmt: skip
    every = [0.0, *(trial.delta_bic for trial in trials)]
    made = layout("ΔBIC", bargap=0.25)
    low, high = min(every), max(every)
    made["xaxis"] |= {**AXIS.ticks(low, high), "tickangle": 0}
    made["narrow"] |= {"xaxis": {**made["xaxis"], **AXIS.ticks(low, high, FEW)}}
    made["yaxis"] = axis(categoryorder="array", categoryarray=names, tickmode="array", tickvals=names)
    return Plot(
        "Effects",
        f"ΔBIC in favour of each effect at its best location, beyond {LINEAR:g} on a logarithmic axis; location, p and size show on"
        " touch or hover. With a misfit that is large enough nearly every effect lowers the deviance.",
        {"data": traces, "layout": made},
        still,
        height=120 + ROW * len(trials),
    )


def _hover_text(trial: TrialRecord) -> str:
    said = f"{trial.location}, ΔBIC = {trial.delta_bic:.1f}, {chance(trial.p, LEAST_OF_A_DOUBLE)}"
    return "<br>".join([said, *map(sized, trial.parameters)])
