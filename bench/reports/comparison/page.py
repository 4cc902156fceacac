"""The page of a comparison."""

from __future__ import annotations

from bench.plan.page import Block, Command, Drawn, Page, Prose, Section, Table
from bench.reports.comparison.comparison import SAME_DATA, Comparison, unknowns_table
from bench.reports.pages.document import document
from bench.reports.pages.made_by import command_line
from ksmea.show.charts.intervals_chart import intervals_chart
from ksmea.show.text import capital


def comparison_page(comparison: Comparison) -> bytes:
    """Findings of both sides, their parameters on one axis, and the settings that differ."""
    first, second = comparison.first, comparison.second
    unknowns = {
        name: {"a": shown, "b": second.unknowns[name]}
        for name, shown in first.unknowns.items()
        if name in second.unknowns
    }
    blocks: list[Block] = [Prose(f"a: {first.name}: {first.verdict}\nb: {second.name}: {second.verdict}")]
    about = f"Differences are in combined standard deviations σ of two independent measurements.\n{SAME_DATA if comparison.is_of_same_data else ''}"
    of_unknowns: list[Block] = [Prose(about), Table(unknowns_table(comparison), file="compare.csv")]
    if unknowns:
        of_unknowns.append(
            Drawn(
                intervals_chart(
                    unknowns,
                    {},
                    "Values and intervals of the parameters that both have, relative to b.",
                    capital(comparison.of_unknowns),
                )
            )
        )
    differing: tuple[Block, ...] = (
        (Table(comparison.settings),) if len(comparison.settings) else (Prose("No setting differs."),)
    )
    sections = [
        Section("Findings", tuple(blocks)),
        Section("Parameters", tuple(of_unknowns)),
        Section("Verdict, misfit and effort", (Table(comparison.facts),)),
        Section("Settings that differ", differing),
        Section(
            "Made by",
            tuple(
                Command(command_line(side.plan.command), f"{name} (commit {side.plan.commit}):")
                for name, side in (("a", first), ("b", second))
            ),
        ),
    ]
    title = f"{first.name} and {second.name}"
    return document(title, Page(comparison.verdict), sections, {"comparison": [first.name, second.name]}, {})
