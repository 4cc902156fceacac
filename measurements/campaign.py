"""Several measured runs of one machine: `measurement=campaign measurement.path=campaign.yaml`.

    runs:
      - {name: bare, file: bare.csv}
      - {name: trial, file: trial.csv, weights: [{position: 0.2, g_mm: 150, angle_deg: 30}]}

- `file`, a CSV file as `measurement=file` reads it, relative to the YAML file. Or one `file` next to `runs`, whose column
  `run` has the names of the runs.
- `weights`, the known unbalance that the shaft carried in this run in addition to its own: `position` from the left end
  (m), size (g mm) and `angle_deg` (0 if not given), counted from where the model's unbalance phases are, towards the
  direction of rotation. If the model fixes the phase of its unbalance, angles are from there. A weight without `g_mm`
  is to be found: two unknowns of the run, within `at_most_g_mm` (the largest unbalance of the model if not given).
  `size: 5 g @ 120 mm` or `size: 2.5 oz in` may stand for `g_mm`, and `at_most` for `at_most_g_mm`; `planes` next to
  `runs` has radii and holes (`measurements/balancing_planes.py`).
- `direction` (up, down, steady), which a column `time_s` says too; `speeds: [from, to]`, the range that is used (rpm).
- A speed may be measured several times in a run.
- `own: [names]` next to `runs`: unknowns of which each run has its own, called name@run. All others are shared: bearings,
  unbalance and the origin of phases.
- `noise`: `shared`, all runs have the same if it is estimated, or `own`, each its own relative part and floor.

A speed and channel may stand several times in a run: repeats. A column `time_s` (s, of one clock for all runs) says when each was
measured, from which a drift over time is seen, and the rate of a run whose speed sweeps.

All runs have the same channels, all of them phases or none, and all of them `sigma_um` or none. If files say at which edge of the
keyphasor's mark their phases count from, all say the same, unless each run has its `own: [phase_origin]`. docs/campaigns.md says more.
"""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path

import numpy as np

from ksmea.errors import SettingError, shortened
from ksmea.measurement.campaign import Campaign, Run
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Layout, Measurement
from ksmea.measurement.noise import Noise
from ksmea.measurement.speeds import SpeedHistory
from ksmea.plugins.source import MeasurementSource, ProblemSettings
from ksmea.settings.document import Block, inside
from ksmea.settings.settings import setting
from ksmea.settings.strict_yaml import parse
from ksmea.settings.strict_yaml import read_bytes as read_yaml
from measurements.campaign_document import Document, RunEntry, read_document
from measurements.common_speeds import at_compared_speeds
from measurements.formats.waveforms.keyphasor import require_one_edge
from measurements.run_up import RunUp, run_up
from measurements.run_up_rows import MAX_BYTES, Rows, notation_of, read_bytes, rows_of, rows_of_run, text_of
from measurements.shared_speeds import at_shared_speeds

ORIGIN = "phase_origin"  # which runs with marks of their own have of their own
STEADY = "steady"  # direction of a run whose states settle at each speed
OF_TIMES = {"run-up": "up", "coast-down": "down"}  # direction of a run by that of its `SpeedHistory`
MOST_BYTES = 4 * MAX_BYTES  # of all data files together


@dataclass(frozen=True)
class CampaignFile(MeasurementSource):
    """Measured runs of one machine, with or without known weights, from a YAML file.

    The file names their CSV files.
    """

    path: str = setting("", "the YAML file; docs/campaigns.md shows its keys")
    incomplete: str = setting(
        "refuse",
        "what becomes of a speed that lacks a channel: an error, the speed is left out, or channels (and with a reference runs) with"
        " speeds of their own are interpolated to common ones",
        choices=("refuse", "drop", "interpolate"),
    )
    reference: str = setting(
        "",
        "name of a run: only how the runs differ counts, at the speeds that two or more have, so that what is alike in all"
        " runs cancels; which run it is makes no difference; empty: all data count",
    )

    def check(self) -> None:
        if not self.path:
            raise SettingError(
                "path: expected the YAML file of a campaign, got none; give measurement.path=campaign.yaml"
                " (docs/campaigns.md shows one)"
            )
        self._runs  # noqa: B018 – reading is checking

    @property
    def kind(self) -> str:
        return "complex" if np.iscomplexobj(self._runs[0].values) else "amplitude"

    @property
    def noise(self) -> Noise | None:
        """The noise as the files state it, datum by datum; None if they do not."""
        sigma = [run.sigma for run in self._runs if run.sigma is not None]
        return Noise(0.0, np.concatenate(sigma)) if sigma else None

    @property
    def remarks(self) -> tuple[str, ...]:
        """Remarks on data of the files that were left out."""
        names = [entry.name for entry in self._document.runs]
        of_runs = (f"run {name}: {remark}" for name, run in zip(names, self._runs) for remark in run.remarks)
        others = dict.fromkeys(name for rows in self._rows.values() for name in rows.run or () if name not in names)
        left_out = f"left out the rows of runs that are not named here: {shortened(', '.join(others))}"
        return (*of_runs, *([left_out] if others else []))

    def fingerprint(self) -> str:
        """Hash of the content of all files: a changed one is another measurement."""
        contents = hashlib.sha256(self._content)
        for content in self._contents.values():
            contents.update(hashlib.sha256(content).digest())
        return contents.hexdigest()[:16]

    def layout(self, settings: ProblemSettings) -> Layout:
        """Speeds and channels of all runs; where they have phases, their origin is not known."""
        first, file = self._runs[0], self._document.runs[0].file
        return Layout(
            np.concatenate([run.speed for run in self._runs]),
            first.channels,
            self.kind,
            self.path,
            phase_known=False,
            locations=tuple(f"{file} line {line}" for line in first.first_lines),
            campaign=self._campaign,
        )

    def read(self) -> Measurement:
        """All runs, one after the other; their times where all of them have a column `time_s`."""
        times = [run.time for run in self._runs if run.time is not None]
        file = self._document.runs[0].file
        return Measurement(
            np.concatenate([run.speed for run in self._runs]),
            self._runs[0].channels,
            np.concatenate([run.values for run in self._runs]),
            self.noise,
            Path(self.path).name,
            phase_known=False,
            campaign=self._campaign,
            time=np.concatenate(times) if len(times) == len(self._runs) else None,
            notation=notation_of(text_of(self._contents[file], file), file),
        )

    @property
    def _campaign(self) -> Campaign:
        runs = (
            Run(
                entry.name,
                len(run.speed),
                entry.weights,
                _direction(entry, run),
                entry.unknown_weights,
                _swept(entry, run),
            )
            for entry, run in zip(self._document.runs, self._runs)
        )
        document = self._document
        return Campaign(tuple(runs), document.own, document.has_own_noise, self.reference, document.planes)

    @cached_property
    def _content(self) -> bytes:
        return read_yaml(self.path)

    @cached_property
    def _document(self) -> Document:
        return read_document(Block.of_document(self.path, parse(self._content, self.path), "runs of one machine"))

    @cached_property
    def _contents(self) -> dict[str, bytes]:
        """Content of each data file; `SettingError` before any is read if they are too large together."""
        entries = {entry.file: entry for entry in self._document.runs}
        paths = [Path(file).expanduser() for file in entries]
        size = sum(path.stat().st_size for path in paths if path.is_file())
        if size > MOST_BYTES:
            raise SettingError(
                f"{self.path}: expected at most {MOST_BYTES >> 20} MB of data files, got {size >> 20} MB; leave runs out"
            )
        return {file: inside(entry.block, "file", partial(read_bytes, file)) for file, entry in entries.items()}

    @cached_property
    def _rows(self) -> dict[str, Rows]:
        texts = {file: text_of(content, file) for file, content in self._contents.items()}
        if ORIGIN not in self._document.own:
            require_one_edge(self.path, texts)
        return {file: rows_of(text, file) for file, text in texts.items()}

    @cached_property
    def _runs(self) -> tuple[RunUp, ...]:
        """The runs with the channels of the first, in its order."""
        runs = [self._read(entry) for entry in self._document.runs]
        alike = [_alike(entry, run, runs[0]) for entry, run in zip(self._document.runs, runs)]
        names = [entry.name for entry in self._document.runs]
        if not self.reference:
            return tuple(alike)
        interpolate = self.incomplete == "interpolate"
        return tuple(at_compared_speeds(alike, names, self.reference, self.path, interpolate=interpolate))

    def _read(self, entry: RunEntry) -> RunUp:
        rows = self._rows[entry.file]
        if self._document.is_one_file:
            rows = inside(entry.block, "name", partial(rows_of_run, rows, entry.name, entry.file))
        elif rows.run is not None:
            raise entry.block.error("file", f"{entry.file}: expected one run, got a column run; give file next to runs")
        return inside(entry.block, "", partial(self._run_up, rows, entry))

    def _run_up(self, rows: Rows, entry: RunEntry) -> RunUp:
        remark = None
        if self.incomplete == "interpolate":
            rows, remark = at_shared_speeds(rows, entry.file)
        drop = self.incomplete == "drop"
        found = run_up(rows, entry.file, entry.speed_from, entry.speed_to, drop, least=1, repeats=True)
        return dataclasses.replace(found, remarks=(remark, *found.remarks)) if remark else found


def _swept(entry: RunEntry, run: RunUp) -> SpeedHistory | None:
    """The course of the speed in a run; None in steady states, which may be measured one after the other."""
    return None if entry.direction == STEADY else run.history


def _direction(entry: RunEntry, run: RunUp) -> str:
    """Direction of the speed in a run, as the file states it, or else by its times.

    Raises `SettingError` if these contradict each other.
    """
    history = run.history
    of_times = OF_TIMES.get(history.direction, "") if history is not None and history.from_times else ""
    if of_times and entry.direction not in ("", STEADY, of_times):
        raise entry.block.error(
            "direction",
            f"expected {of_times}, as time_s in {entry.file} says, got {entry.direction}; correct one of the two",
        )
    return entry.direction or of_times


def _alike(entry: RunEntry, run: RunUp, first: RunUp) -> RunUp:
    """A run with its channels in the order of the first.

    Raises `SettingError` if it has other ones, or is of another kind.
    """
    if set(run.channels) != set(first.channels):
        raise entry.block.error(
            "file",
            f"expected the channels of the first run ({_named(first.channels)}), got {_named(run.channels)}; leave out"
            " what not all runs have",
        )
    for what, own, others in (
        ("phases", np.iscomplexobj(run.values), np.iscomplexobj(first.values)),
        ("sigma_um", run.sigma is not None, first.sigma is not None),
    ):
        if own != others:
            raise entry.block.error("file", f"expected {what} in all runs or in none; add them, or leave them out")
    order = [run.channels.index(channel) for channel in first.channels]
    return _reordered(run, order)


def _reordered(run: RunUp, order: Sequence[int]) -> RunUp:
    return dataclasses.replace(
        run,
        channels=tuple(run.channels[index] for index in order),
        first_lines=tuple(run.first_lines[index] for index in order),
        values=run.values[:, order],
        sigma=None if run.sigma is None else run.sigma[:, order],
        order=run.order[:, order],
    )


def _named(channels: Sequence[Channel]) -> str:
    return ", ".join(map(str, channels))
