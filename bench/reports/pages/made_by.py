"""End of every page: status of runs, settings, and provenance of the results."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import pandas as pd

from bench.jobs.lines import RESULTS
from bench.jobs.records import NOT_RUN
from bench.plan.page import Block, Command, Folded, Prose, Section, Table
from bench.plan.plan import Plan
from bench.reports.runs import without_class

OF_CODE = "parts"  # of settings: modules that take part, which nobody chooses
MOST_FAILED = 50  # runs whose reasons are on the page; runs.csv has all


def command_line(words: Sequence[str]) -> str:
    """Words of the command line as one command, quoted for a shell.

    >>> print(command_line(["problem.file='Läufer.yaml'"]))
    python -m bench "problem.file='Läufer.yaml'"
    """
    return " ".join(["python", "-m", "bench", *map(_quoted, words)])


def _quoted(word: str) -> str:
    """Quote a word for a shell; in double quotes if it has single ones but nothing that they expand."""
    return f'"{word}"' if "'" in word and not set('"$`\\!') & set(word) else shlex.quote(word)


def runs_section(runs: pd.DataFrame) -> Section:
    """How many runs ended how, and why those failed that did."""
    counts = Counter(runs["status"])
    counted = ", ".join(f"{count} {status}" for status, count in counts.most_common()) or "none planned"
    failed = runs[~runs["status"].isin([*RESULTS, NOT_RUN])]
    blocks: list[Block] = [Prose(f"{len(runs)} run{'s' * (len(runs) > 1)}: {counted}.")]
    if len(failed):
        columns = [name for name in failed if name in _FAILED or (name not in _NOT_PLACE and _is_place(failed[name]))]
        shown = failed[[*dict.fromkeys([*columns, "status", "error"])]].head(MOST_FAILED)
        shown = shown.assign(error=shown["error"].fillna("").map(without_class))
        blocks.append(Table(shown, "Runs without a result", "runs.csv"))
        if "key" in failed:
            blocks.append(Command(f"python -m bench explain {failed['key'].iloc[0]}", "Why, with the traceback:"))
    return Section("Runs", tuple(blocks))


_FAILED = ("key", "repetition")
_NOT_PLACE = ("cell", "seed", "status", "error")


def _is_place(column: pd.Series) -> bool:
    """Whether a column of runs.csv describes planned runs: it is filled even in rows without a result."""
    return bool(column.notna().all() and (column.astype(str) != "").all())


def settings_section(plan: Plan) -> Section:
    """The settings that all cells share, and how each cell differs."""
    flat = [{name: value for name, value in flattened(cell.settings) if name != OF_CODE} for cell in plan.cells]
    names = list(dict.fromkeys(name for each in flat for name in each))
    values = {name: [each.get(name, "") for each in flat] for name in names}
    alike = [(name, found[0]) for name, found in values.items() if len(set(found)) == 1]
    differing = {name: found for name, found in values.items() if len(set(found)) > 1}
    blocks: list[Block] = []
    if differing:
        frame = pd.DataFrame({"cell": range(len(flat)), **differing})
        blocks.append(Folded(f"What the {len(flat)} cells differ in", (Table(frame, "Settings that differ"),)))
    shared = Table(pd.DataFrame(alike, columns=["setting", "value"]))
    blocks.append(Folded(f"{len(alike)} settings" + (" of all cells" if differing else ""), (shared,)))
    return Section("Settings", tuple(blocks))


def flattened(settings: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, str]]:
    """Settings by their names on the command line.

    >>> dict(flattened({"optimizer": {"name": "de", "population": 20}, "samples": 40}))
    {'optimizer': 'de', 'optimizer.population': '20', 'samples': '40'}
    """
    for name, value in settings.items():
        path = f"{above}.{name}" if above else name
        if isinstance(value, Mapping) and value:
            yield from flattened(value, path)
        elif name == "name" and above:
            yield above, str(value)
        else:
            yield path, "null" if value is None else str(value)


def made_by_section(plan: Plan, files: Sequence[str]) -> Section:
    """The command that makes the same again, commit, seeds and libraries, and the files next to the page."""
    seeds = sorted({cell.seed for cell in plan.cells})
    last = max((run.repetition for run in plan.runs), default=0)
    libraries = ", ".join(f"{name} {version}" for name, version in plan.versions.items())
    facts = [
        f"commit {plan.commit}",
        f"{len(seeds)} seeds" if len(seeds) > 3 else f"seed {', '.join(map(str, seeds)) or 'none'}",
        f"repetitions 0 to {last}" if last else "one repetition",
        f"libraries: {libraries}",
        f"planned on {plan.platform}" if plan.platform else "",
    ]
    lines = [*(f"  {fact}" for fact in facts if fact), *(f"  note: {note}" for note in plan.notes)]
    return Section(
        "Made by",
        (
            Command(command_line(plan.command), "To repeat it (finished runs are kept):"),
            Prose("\n".join(lines)),
            Prose(f"Files next to this page: {', '.join(files)}"),
        ),
    )
