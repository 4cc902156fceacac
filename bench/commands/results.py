"""Commands on results that are there, by name: they read plan and records, and `verify` alone runs anything."""

from __future__ import annotations

from collections.abc import Callable

from bench.commands.explain import explain
from bench.commands.folders import folders, one_folder
from bench.commands.reference import write_reference
from bench.commands.status import status
from bench.commands.verify import verify
from bench.reports.collect import collect, collect_all


def collect_again(words: list[str]) -> int:
    """`collect NAME|DIR`: tables and figures from plan and records; 0 where every planned run has a result."""
    outputs = folders(words, "collect")
    codes = [collect(output) for output in outputs]
    if len(outputs) > 1:
        collect_all(outputs[0].parent, outputs)
    return max(codes)


def reference(words: list[str]) -> int:
    """`reference NAME|DIR`: make results/reference/ of an experiment that is done, by committed code."""
    for path in write_reference(one_folder(words, "reference")):
        print(f"written: {path}")
    return 0


COMMANDS: dict[str, Callable[[list[str]], int]] = {
    "status": status,
    "explain": explain,
    "collect": collect_again,
    "verify": verify,
    "reference": reference,
}
