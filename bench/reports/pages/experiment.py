"""Page of an experiment, `index.html` in its folder.

It is made of plan and records alone: equal records give equal bytes.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bench.jobs.records import NOT_FAILED, UNFINISHED
from bench.plan.page import Block, Page, Picture, Prose, Section
from bench.plan.plan import Plan
from bench.plan.report import Made
from bench.reports.pages.document import PAGE, document
from bench.reports.pages.made_by import made_by_section, runs_section, settings_section
from bench.reports.pages.prose import is_aligned
from ksmea.errors import shortened

OLDEST_STUDY = "identify"  # of plans that name none
LONGEST_HEADLINE = 300  # characters that an index shows


def experiment_page(
    plan: Plan, made: Made, drawings: Mapping[str, bytes], when: str, page: Page | None = None
) -> bytes:
    """The page of a report, as HTML.

    `drawings` are its figures by name, `when` is when the last of its sessions began.
    """
    page = page or plain_page(made, drawings)
    files = sorted({*made.files, *drawings} - {PAGE})
    sections = [*page.sections]
    sections += [runs_section(made.runs)] if len(plan.runs) else []
    sections += [settings_section(plan)] if plan.cells else []
    sections.append(made_by_section(plan, files))
    return document(heading(plan), page, sections, facts(plan, made, page, when), drawings)


def heading(plan: Plan) -> str:
    """The name of the experiment, and of the file of a measurement where all cells have the same."""
    paths = {str((cell.settings.get("measurement") or {}).get("path") or "") for cell in plan.cells}
    (path,) = paths if len(paths) == 1 else ("",)
    return f"{plan.name}: {Path(path).name}" if path else plan.name


def facts(plan: Plan, made: Made, page: Page, when: str) -> dict[str, Any]:
    """Facts on an experiment for an index."""
    return {
        "name": plan.name,
        "study": ", ".join(studies(plan)),
        "when": when,
        "headline": shortened(page.headline, LONGEST_HEADLINE),
        "runs": len(made.runs),
        "failed": int((~made.runs["status"].isin(NOT_FAILED)).sum()),
        "unfinished": int(made.runs["status"].isin(UNFINISHED).sum()),
        "commit": plan.commit,
    }


def studies(plan: Plan) -> list[str]:
    """The studies of a plan, in the order of its cells."""
    named = ((cell.settings.get("study") or {}).get("name", OLDEST_STUDY) for cell in plan.cells)
    return list(dict.fromkeys(map(str, named)))


def plain_page(made: Made, drawings: Mapping[str, bytes]) -> Page:
    """Page of a report that defines no page: its text, and its PNG figures."""
    pictures: tuple[Block, ...] = tuple(Picture(name, name) for name in drawings if name.endswith(".png"))
    sections = [Section("Result", (Prose(made.text),)), *([Section("Figures", pictures)] if pictures else [])]
    return Page(first_line(made.text), tuple(sections))


def first_line(text: str) -> str:
    """The first line that is not a row of a table."""
    return next((line.strip() for line in text.splitlines() if line.strip() and not is_aligned(line)), "")
