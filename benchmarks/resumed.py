"""Rows of a CSV file that are computed in processes, each as soon as it is done.

Rows that the file has already are not computed again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from multiprocessing import Pool
from pathlib import Path
from typing import Any

import pandas as pd

N_PROCESS = 2

Task = tuple[Any, ...]


def add_missing_rows(
    path: Path, columns: Sequence[str], row: Callable[..., dict[str, Any]], tasks: Iterable[Task]
) -> None:
    """Adds `row(*task)` to the file for each task that it lacks.

    A task is the values of the first columns.
    """
    tasks = list(dict.fromkeys(tasks))
    if path.exists() and tasks:
        done = set(pd.read_csv(path)[list(columns[: len(tasks[0])])].itertuples(index=False, name=None))
        tasks = [task for task in tasks if task not in done]
    with Pool(N_PROCESS) as pool:
        for made in pool.imap_unordered(_Row(row), tasks):
            pd.DataFrame([made]).reindex(columns=columns).to_csv(path, mode="a", header=not path.exists(), index=False)


def rows_of(
    arguments: Sequence[str], columns: Sequence[str], row: Callable[..., dict[str, Any]], causes: Iterable[str]
) -> pd.DataFrame:
    """Rows of a file on a command line, `N FILE [CAUSE …]` or `FILE`.

    With a number they are completed first, so that it has N draws of each cause.
    """
    if not arguments[0].isdigit():
        return pd.read_csv(arguments[0])
    n_draw, path, chosen = int(arguments[0]), Path(arguments[1]), arguments[2:] or list(causes)
    add_missing_rows(path, columns, row, ((cause, number) for number in range(n_draw) for cause in chosen))
    return pd.read_csv(path)


class _Row:
    """A row of a task, in another process."""

    def __init__(self, row: Callable[..., dict[str, Any]]) -> None:
        self.row = row

    def __call__(self, task: Task) -> dict[str, Any]:
        return self.row(*task)
