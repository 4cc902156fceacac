"""A bar of progress, with the rate and the time that is left."""

from __future__ import annotations

from tqdm import tqdm

from bench.command_line.output_level import hides_progress


def progress_bar(name: str, n_step: int, unit: str = "run") -> tqdm:
    """A bar on the error stream; none where nobody looks at a terminal, or only errors are to be shown."""
    return tqdm(total=n_step, desc=name, unit=unit, disable=hides_progress(), dynamic_ncols=True)
