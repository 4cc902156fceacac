"""On what, and of which code, figures were measured."""

from __future__ import annotations

import os
import platform
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import scipy

from bench.plan.provenance import commit


@dataclass(frozen=True)
class Machine:
    processor: str
    cores: int
    python: str
    numpy: str
    scipy: str
    commit: str

    def columns(self) -> dict[str, str | int]:
        return asdict(self)

    def __str__(self) -> str:
        return (
            f"{self.processor}, {self.cores} cores; Python {self.python}, numpy {self.numpy}, scipy {self.scipy};"
            f" commit {self.commit}"
        )


def this_machine() -> Machine:
    return Machine(
        processor=_processor(),
        cores=os.cpu_count() or 1,
        python=platform.python_version(),
        numpy=np.__version__,
        scipy=scipy.__version__,
        commit=commit(),
    )


def _processor() -> str:
    """Its name and clock as the kernel tells it, or what Python knows."""
    information = Path("/proc/cpuinfo")
    if information.is_file():
        facts = dict(
            (part.strip() for part in line.split(":", 1))
            for line in information.read_text().splitlines()
            if ":" in line
        )
        if "model name" in facts:
            return f"{facts['model name']} (model {facts.get('model', '?')})"
    return platform.processor() or platform.machine()
