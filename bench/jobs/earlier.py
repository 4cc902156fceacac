"""Results of an earlier plan in the same folder that a new plan does not show any more."""

from __future__ import annotations

import shlex
from pathlib import Path

from bench.jobs.records import finished_keys
from bench.plan.folder import planned_before
from bench.plan.plan import Plan


def earlier_note(plan: Plan, output: Path) -> str:
    """What a plan that is about to be written leaves out of the results in its folder, and how they are shown again; '' where it
    shows them all."""
    found = planned_before(output)
    if found is None:
        return ""
    asked = {run.question for run in plan.runs}
    left_out = {run.key for run in found.runs if run.question not in asked}
    n = len(left_out & finished_keys(output)) if left_out else 0
    if not n:
        return ""
    command = shlex.join(["python", "-m", "bench", *found.command])
    if n == 1:
        said = "1 earlier result in this folder, of other settings or files, is no longer shown: its record is kept, and its"
        said += " command shows it again"
    else:
        said = f"{n} earlier results in this folder, of other settings or files, are no longer shown: their records are kept, and"
        said += " their command shows them again"
    return f"note: {said}: {command} (another output=DIR keeps both side by side)"
