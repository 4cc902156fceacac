"""Effects by ΔBIC, as text, table, figure and page rank them."""

from __future__ import annotations

from ksmea.records.diagnosis import DiagnosisRecord, TrialRecord
from ksmea.show.charts.chart import Axis, Bars, Chart, Element, Level, named_rows, one_panel
from ksmea.show.charts.colours import ALIKE, CONTEXT, MODEL
from ksmea.show.diagnosis_tables import sized
from ksmea.show.text import LEAST_OF_A_DOUBLE, chance

QUANTITY = "ΔBIC in favour of the effect"
LINEAR = 10.0  # of ΔBIC: the axis is linear up to here to both sides, and logarithmic beyond
NAMED, AS_WELL, OTHER = "named", "explains the data about as well", "other effects"
COLOURS = {NAMED: MODEL, AS_WELL: ALIKE, OTHER: CONTEXT}
ROW = 0.3  # inches of each effect


def ranking_chart(record: DiagnosisRecord) -> Chart:
    """ΔBIC of the best location of each effect.

    It is coloured if the effect is named or explains the data about as well.
    """
    trials = best_trials(record)
    elements: list[Element] = []
    for rank, colour in COLOURS.items():
        mine = [(at, trial) for at, trial in enumerate(trials) if standing(record, trial.effect) == rank]
        if mine:
            at, of = zip(*mine)
            said = list(map(_said, of))
            elements.append(Bars(at, [trial.delta_bic for trial in of], along="x", name=rank, colour=colour, said=said))
    elements.append(Level(at=0.0, along="x", dash="solid", width=0.8))
    y = named_rows(f"{trial.effect} ({trial.location})" for trial in trials)
    return one_panel(
        elements, Axis(QUANTITY, "symlog", linear=LINEAR, better="high"), y,
        "Effects",
        f"ΔBIC in favour of each effect at its best location, beyond {LINEAR:g} on a logarithmic axis; location, p and size show on"
        " touch or hover. With a misfit that is large enough nearly every effect lowers the deviance.", height=ROW * len(trials) + 0.2, width=7.5,
    )  # fmt: skip


def _said(trial: TrialRecord) -> str:
    said = f"{trial.location}, ΔBIC = {trial.delta_bic:.1f}, {chance(trial.p, LEAST_OF_A_DOUBLE)}"
    return "<br>".join([f"{trial.effect}: {said}", *map(sized, trial.parameters)])


def best_trials(record: DiagnosisRecord) -> list[TrialRecord]:
    """The trial of each effect at its best location, in the order of the ranking."""
    best: dict[str, TrialRecord] = {}
    for trial in record.ranking:
        best.setdefault(trial.effect, trial)
    return list(best.values())


def standing(record: DiagnosisRecord, effect: str) -> str:
    """Whether an effect is named, explains the data about as well, or is one of the others.

    If the misfit is large enough, nearly every effect lowers the deviance significantly.
    """
    if effect in record.named:
        return NAMED
    return AS_WELL if effect in record.ambiguity_group else OTHER
