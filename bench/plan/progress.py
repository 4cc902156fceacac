"""The progress of one run, for a study of many steps."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tqdm import tqdm

from bench.plan.setup import Draw
from ksmea.numerics.parallel import CAN_FORK, NO_FORK

TICK = 1.0  # s


@contextmanager
def progress_of(draw: Draw, name: str, n_step: int | None = None) -> Iterator[Callable[[], None]]:
    """Function to call at each step: it moves a progress bar if the run shows its own progress.

    The bar is full at the end, and grows if there are more steps than the expected `n_step` (None: number not known).
    Its clock goes on during a step, however long the step takes.
    """
    tqdm.set_lock(threading.RLock())  # a lock between processes would outlive this worker
    with (
        tqdm(total=n_step, desc=name, unit=" steps", disable=None if draw.with_progress else True) as bar,
        _ticking(bar),
    ):

        def step() -> None:
            bar.total = n_step and max(n_step, bar.n + 1)
            bar.update()

        yield step
        bar.update((bar.total or bar.n) - bar.n)


@contextmanager
def _ticking(bar: tqdm) -> Iterator[None]:
    """Draw a bar that is shown anew every second."""
    ended = threading.Event()

    def tick() -> None:
        if CAN_FORK:  # the main thread says when it may come
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        while not ended.wait(TICK):
            with NO_FORK:
                bar.refresh()

    thread = threading.Thread(target=tick, daemon=True)
    if not bar.disable:
        thread.start()
    try:
        yield
    finally:
        ended.set()
        if thread.is_alive():
            thread.join()
