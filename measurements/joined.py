"""Records at steady speeds, each in a file of its own, as the rows of one run."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import Any

from ksmea.errors import SettingError
from measurements.common_speeds import averaged
from measurements.file import File
from measurements.formats.waveforms.keyphasor import require_one_edge
from measurements.run_up import run_up
from measurements.run_up_rows import Rows


def joined(sources: Sequence[File]) -> tuple[Rows, tuple[str, ...]]:
    """The rows of all files, and remarks that name the file.

    Standard deviations only if every file has them. Times are left out, as each file has a clock of its own. Raises
    `SettingError` if files do not fit each other.
    """
    rows = [source.used_rows for source in sources]
    first = sources[0].path
    for source, own in zip(sources, rows):
        if (own.phase is None) != (rows[0].phase is None) or set(own.channel) != set(rows[0].channel):
            raise SettingError(
                f"{source.path}: expected phases and channels as in {first}, got others; import it by itself"
            )
    require_one_edge(first, {source.path: "\n".join(f"# {each}" for each in source.remarks) for source in sources})

    def column(name: str) -> Any:
        parts = [getattr(each, name) for each in rows]
        return None if any(part is None for part in parts) else list(chain(*parts))

    names = ("line", "speed", "channel", "amplitude", "phase", "sigma")
    whole = Rows(**{name: column(name) for name in names}, time=None, run=None)
    remarks = [f"{source.path}: {each}" for source in sources for each in source.remarks]
    if sources[0].repeats == "average":
        whole, averaging = averaged(whole)
        remarks += [averaging] if averaging else []
    run_up(whole, first, None, None, sources[0].incomplete == "drop", least=1)  # refuses what does not fit
    return whole, tuple(remarks)
