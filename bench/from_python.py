"""Whole experiments from Python: `bench.run("table3", repetitions=1)`.

The experiment is the command line's own, in a process of its own: its workers never import the caller's script, and the
numbers are the same to the last digit. So nothing that calls it needs a main guard.
"""

from __future__ import annotations

import codecs
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import imread

from bench.command_line.output_level import PROGRESS
from bench.command_line.overrides import override
from bench.jobs.records import NOT_FAILED, UNFINISHED
from bench.plan.plan import Plan, read_plan
from bench.plan.report import report_named
from ksmea.errors import SettingError, visible_lines
from ksmea.plugins import registry
from ksmea.show.charts.picture import ShownFigure, figure_of

BAD_INPUT, INTERRUPTED = 2, 130
# Not `-m bench`: where it runs there may be a folder of that name. The main module is imported first, as it says why.
LAUNCH = "import sys, bench.__main__; from bench import main; sys.exit(main.run(sys.argv[1:], refuse=print))"


@dataclass(frozen=True)
class Experiment:
    """Results of an experiment in their folder. `print` gives the terminal's table.

    Args:
        output: folder of the results.
    """

    output: Path

    @property
    def plan(self) -> Plan:
        """Plan of the experiment: cells, runs and seeds."""
        return read_plan(self.output)

    @property
    def runs(self) -> pd.DataFrame:
        """A row per planned run, failed and missing ones too."""
        return pd.read_csv(self.output / "runs.csv", dtype={"key": str})

    @property
    def failed(self) -> int:
        """Number of runs that ended without a result. Runs that have not ended are `unfinished`."""
        return int((~self.runs["status"].isin(NOT_FAILED)).sum())

    @property
    def unfinished(self) -> int:
        """Number of planned runs that were not run, were interrupted, or are still running.

        Another call with the same arguments computes them.
        """
        return int(self.runs["status"].isin(UNFINISHED).sum())

    def to_frame(self) -> pd.DataFrame:
        """The experiment's table, tidy."""
        return pd.read_csv(self.output / f"{self.plan.name}.csv")

    def to_json(self, path: str | Path | None = None) -> str:
        """Table as JSON, a mapping per row.

        Args:
            path: file to write it to as well.
        """
        text = json.dumps(json.loads(self.to_frame().to_json(orient="records")), indent=1)
        if path is not None:
            Path(path).write_text(text + "\n", encoding="utf-8")
        return text

    def plot(self, axes: Axes | None = None) -> Figure:
        """Figure of the experiment as it was written.

        Args:
            axes: axes to show it on. Default: a new figure.
        """
        picture = imread(self.output / f"{self.plan.name}.png")
        if axes is None:
            height, width = picture.shape[:2]
            axes = ShownFigure(figsize=(width / 130, height / 130), dpi=130).add_axes((0.0, 0.0, 1.0, 1.0))
        axes.imshow(picture)
        axes.set_axis_off()
        return figure_of(axes)

    def __str__(self) -> str:
        return visible_lines(report_named(self.plan.report.table).make(self.plan, self.output).text)

    def _repr_html_(self) -> str:
        return f"{self.to_frame().to_html(index=False, float_format='%.4g')}<pre>{escape(str(self))}</pre>"


def run(experiment: str | None = None, *, output: str | Path | None = None, **settings: Any) -> Experiment:
    """Run an experiment, or what is missing of it, and return its results; progress shows on a terminal.

    Runs that fail do not raise: they are counted (`failed`), as are runs without an end (`unfinished`).

    Args:
        experiment: name of an experiment. Default: the settings alone.
        output: folder of the results. Default: results/NAME below the working directory.
        **settings: settings as on the command line: `repetitions=3`, `problem="rk4"`, `optimizer="pso"`. A mapping holds the
            settings of a plugin, `measurement={"relative": 0.05}`, with its own name under "name"; a tuple is a sweep,
            `samples=(40, 70)`.

    Returns:
        Results in their folder.

    Raises:
        SettingError: the command line rejects the arguments.

    >>> import bench
    >>> table = bench.run("table5", output=getfixture("tmp_path")).to_frame()
    >>> bool(table["agrees"].all())
    True
    """
    words = [f"+experiment={experiment}"] if experiment is not None else []
    for key, value in settings.items():
        words += _words(key, value)
    folder = Path(output) if output is not None else Path("results") / str(settings.get("name", experiment or "run"))
    words.append(override("output", str(folder.absolute())))
    command = [sys.executable, "-P", "-c", LAUNCH, *words]
    code, printed = _finished(command)
    if code == INTERRUPTED:
        raise KeyboardInterrupt
    if code == BAD_INPUT:
        raise SettingError(printed.strip())
    return Experiment(folder)


def _finished(command: list[str]) -> tuple[int, str]:
    """Exit code and printed text of a process.

    Its progress goes to the terminal; in a notebook, which has none, to the cell.
    """
    if "ipykernel" not in sys.modules:
        done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
        return done.returncode, done.stdout
    environment = {**os.environ, PROGRESS: "1"}
    with (
        tempfile.TemporaryFile("w+", encoding="utf-8") as printed,
        subprocess.Popen(command, stdout=printed, stderr=subprocess.PIPE, env=environment) as process,
    ):
        decoder = codecs.getincrementaldecoder("utf-8")("replace")
        while process.stderr and (shown := os.read(process.stderr.fileno(), 4096)):
            sys.stderr.write(decoder.decode(shown))
            sys.stderr.flush()
        code = process.wait()
        printed.seek(0)
        return code, printed.read()


def _words(key: str, value: Any) -> list[str]:
    """A setting in the command line's grammar; the names of plugins stand without quotes."""
    if key in registry.GROUPS and isinstance(value, str):
        return [f"{key}={value}"]
    if key in registry.GROUPS and isinstance(value, Mapping):
        inner = [(key if name == "name" else f"{key}.{name}", entry) for name, entry in value.items()]
        return [word for name, entry in inner for word in _words(name, entry)]
    if isinstance(value, tuple):
        return [f"{key}={','.join(word.partition('=')[2] for entry in value for word in _words(key, entry))}"]
    return [override(key, value)]
