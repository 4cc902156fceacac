"""Numbers known to a tolerance as charts.

How far the data move each, and what the uncertainty of each unknown is made of.
"""

from __future__ import annotations

from collections.abc import Sequence

from ksmea.records.identification import ParameterRecord
from ksmea.records.inputs import InputRecord
from ksmea.show.charts.chart import Axis, Bars, Chart, Element, Level, Points, named_rows, one_panel
from ksmea.show.charts.colours import CONTEXT, MODEL, PALE_STEEL, category

ROW = 0.3  # inches of each number or unknown
MOST_NAMED = 7  # numbers with a colour of their own
NOISE, OTHERS = "noise", "other numbers"


def inputs_chart(inputs: Sequence[InputRecord]) -> Chart:
    """Change of each number that the data determine, with its standard deviation.

    Both are in units of its stated standard deviation.
    """
    seen = sorted((each for each in inputs if each.is_seen), key=lambda each: -abs(each.pull))
    elements: list[Element] = [Level(at=end, along="x", dash="dash", width=0.8) for end in (-1.0, 1.0)]
    for is_contradicted, name, colour in ((True, "contradicted", MODEL), (False, "as stated", CONTEXT)):
        rows = [(at, each) for at, each in enumerate(seen) if each.is_contradicted == is_contradicted]
        if not rows:
            continue
        at = [row for row, _ in rows]
        off = [(each.value - each.stated) / each.stated_sd for _, each in rows]
        half = [each.sd / each.stated_sd for _, each in rows]
        ends = [x - by for x, by in zip(off, half)], [x + by for x, by in zip(off, half)]
        said = [f"{each.words}: pull {each.pull:+.1f}" for _, each in rows]
        elements.append(Points(off, at, left=ends[0], right=ends[1], name=name, colour=colour, said=said))
    return one_panel(
        elements, Axis("change in stated standard deviations"), named_rows(each.words for each in seen),
        "Numbers known to a tolerance",
        "Change of each number that the data determine, with its standard deviation, in standard deviations of the rotor file;"
        " dashed: one of them.", height=ROW * len(seen) + 0.6, width=7.5,
    )  # fmt: skip


def budget_chart(parameters: Sequence[ParameterRecord]) -> Chart:
    """Shares of the variance of each unknown: noise, the numbers that matter most, all others."""
    rows = [(each.name, each.origin) for each in parameters if each.origin is not None]
    named = list(dict.fromkeys(origin.shares[0][0] for _, origin in rows if origin.shares))[:MOST_NAMED]
    parts = {NOISE: [1 - origin.of_inputs for _, origin in rows]}
    parts |= {name: [dict(origin.shares).get(name, 0.0) for _, origin in rows] for name in named}
    parts[OTHERS] = [1 - sum(of[index] for of in parts.values()) for index in range(len(rows))]
    elements: list[Element] = []
    base = [0.0] * len(rows)
    for number, (name, sizes) in enumerate(parts.items()):
        colour = {NOISE: CONTEXT, OTHERS: PALE_STEEL}.get(name, category(number - 1))
        lengths = [100 * size for size in sizes]
        said = [f"{unknown}: {length:.0f} % {name}" for (unknown, _), length in zip(rows, lengths)]
        elements.append(
            Bars(list(range(len(rows))), lengths, base=base, along="x", name=name, colour=colour, said=said)
        )
        base = [start + length for start, length in zip(base, lengths)]
    return one_panel(
        elements, Axis("share of the variance, %", low=0.0, high=100.0), named_rows(name for name, _ in rows),
        "Sources of uncertainty",
        "Shares of the variance of each unknown by noise and by numbers known to a tolerance: the largest says what to measure better.",
        height=ROW * len(rows) + 0.8, width=7.5,
    )  # fmt: skip
