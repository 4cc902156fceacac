"""The progress of one run, for a study of many steps."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tqdm import tqdm

from bench.plan.draw import Draw


@contextmanager
def progress_of(draw: Draw, name: str, n_step: int | None = None) -> Iterator[Callable[[], None]]:
    """What is to be called at each step: it moves a bar where the run shows its own progress. The bar is full at the end, and
    grows where there are more steps than the `n_step` that were expected; None: nobody knows how many."""
    tqdm.set_lock(threading.RLock())  # a lock between processes would outlive this worker
    with tqdm(total=n_step, desc=name, unit=" steps", disable=None if draw.with_progress else True) as bar:

        def step() -> None:
            bar.total = n_step and max(n_step, bar.n + 1)
            bar.update()

        yield step
        bar.update((bar.total or bar.n) - bar.n)
