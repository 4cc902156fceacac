"""`collect NAME|DIR`: tables and figures from plan and records."""

from __future__ import annotations

from bench.commands.folders import folders
from bench.reports.collect import collect, collect_all


def collect_again(words: list[str]) -> int:
    """Write and print them; 0 where every planned run has a result."""
    outputs = folders(words, "collect")
    codes = [collect(output) for output in outputs]
    if len(outputs) > 1:
        collect_all(outputs[0].parent, outputs)
    return max(codes)
