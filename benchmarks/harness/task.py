"""Work that a process times.

Standard library alone: it is imported where nothing of this project is installed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Task:
    """A piece of work that is prepared and can be run again and again.

    `run` gets the number of the turn, which seeds what is random, and returns a result. `values` makes of that the numbers
    that all sides must agree in, `quality` the number that says how good it is, `parts` the CPU seconds of its parts. A run
    does as many of the row's units as `units` says, such as 100 evaluations.
    """

    run: Callable[[int], Any]
    values: Callable[[Any], Any] | None = None
    quality: Callable[[Any], float] | None = None
    parts: Callable[[Any], dict[str, float]] | None = None
    units: float = 1.0
