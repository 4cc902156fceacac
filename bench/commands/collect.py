"""`collect NAME|DIR`: tables and figures from plan and records."""
# Shorter than 40 lines: one command a file.

from __future__ import annotations

from bench.commands.folders import folders
from bench.reports.collect import collect


def collect_again(words: list[str]) -> int:
    """Write and print them; 0 where every planned run has a result."""
    outputs = folders(words, "collect")
    codes = [collect(output) for output in outputs]
    if len(outputs) > 1:
        from bench.reports.collect_all import collect_all  # loads all of matplotlib

        collect_all(outputs[0].parent, outputs)
    return max(codes)
