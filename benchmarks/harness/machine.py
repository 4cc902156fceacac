"""On what, and of which code, figures were measured."""

from __future__ import annotations

import os
import platform
import re
from pathlib import Path

import numpy as np
import scipy

from bench.plan.provenance import commit

MACHINE = ("processor", "cores", "python", "numpy", "scipy", "commit")
LINE = "{processor}, {cores} cores; Python {python}, numpy {numpy}, scipy {scipy}; commit {commit}"


def this_machine() -> dict[str, str | int]:
    """Columns of a table's line (`MACHINE`)."""
    values = (_processor(), os.cpu_count() or 1, platform.python_version(), np.__version__, scipy.__version__, commit())
    return dict(zip(MACHINE, values, strict=True))


def _processor() -> str:
    """Its name and clock as the kernel tells it, or what Python knows."""
    information = Path("/proc/cpuinfo")
    facts = re.findall(r"(?m)^([\w ]+?)\s*: (.*)$", information.read_text()) if information.is_file() else []
    known = dict(facts)
    if "model name" in known:
        return f"{known['model name']} (model {known.get('model', '?')})"
    return platform.processor() or platform.machine()
