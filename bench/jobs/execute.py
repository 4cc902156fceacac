"""One run: from its settings and seeds to its record.

It is called in a worker process and returns plain data.
"""

from __future__ import annotations

import time
import traceback
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from types import MappingProxyType
from typing import Any

from bench.jobs.lines import FailedRun
from bench.plan.plan import generator, global_entropy
from bench.plan.setup import Draw, Setup
from bench.plan.study import Study
from ksmea.numerics.isolation import global_generators
from ksmea.plugins import registry

LONGEST_MESSAGE, LONGEST_TRACEBACK = 10_000, 100_000  # characters that a record keeps of an error
NO_FILES: Mapping[str, Mapping[str, str]] = MappingProxyType({})


def execute(
    settings: Mapping[str, Any],
    seeds: Mapping[str, list[int]],
    journal: Path | None = None,
    with_curves: bool = False,
    with_progress: bool = False,
    plugins: Mapping[str, Mapping[str, str]] = NO_FILES,
    workers: int = 1,
    with_fine: bool = False,
) -> dict[str, Any]:
    """The record of a run; an error inside it is a record too, with its traceback.

    `with_curves` adds the response curves that figures are made of, `with_fine` those at more speeds, `with_progress` lets it show its own. With a
    journal, model evaluations that an earlier attempt finished are replayed from it. Generators that the process shares are
    seeded by the run and restored after it, so that a plugin that draws from them depends on nothing that ran before.
    `plugins` are plain files of plugins with the digests that they are planned with. At most `workers` processes share the run.
    """
    started = time.perf_counter()
    try:
        with ExitStack() as seeded:
            shared = generator(global_entropy(seeds))
            seeded.enter_context(global_generators(shared))
            for path, planned in plugins.items():
                registry.register_file(Path(path), planned)
            setup = Setup.of(settings)
            study = setup.plugins["study"]
            study.validate(setup)
            for plugin in filter(None, setup.plugins.values()):
                for each in (plugin, *(part for part in plugin.parts if not isinstance(part, Study))):
                    seeded.enter_context(each.seeded(int(shared.integers(2**32))))
            record = study.run(setup, Draw(seeds, journal, with_curves, with_progress, workers, with_fine))
    except (Exception, SystemExit) as error:  # a plugin that calls sys.exit costs its own run only
        record = _failed(error).to_data()
    return {**record, "elapsed": time.perf_counter() - started}


def _failed(error: BaseException) -> FailedRun:
    """Run without a result: the beginning of its message, and the end of its traceback.

    The end names the error.
    """
    message = f"{type(error).__name__}: {error}"
    cut = message if len(message) <= LONGEST_MESSAGE else message[:LONGEST_MESSAGE] + "…"
    return FailedRun("error", cut, traceback.format_exc()[-LONGEST_TRACEBACK:])
