"""A recommended further run as something to do.

The command that takes it along, and of measured data the file that describes it.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.command_line.overrides import override, path_word
from bench.plan.plan import Cell, Plan
from bench.reports.pages.made_by import command_line
from ksmea.errors import visible
from ksmea.measurement.campaign import BARE, weights_of
from ksmea.units import DEGREE, GRAM_MILLIMETRE

CAMPAIGN_FILE, FURTHER_FILE = "campaign.yaml", "further.csv"
OF_FILE = ("path", "speed_from", "speed_to")  # settings of `measurement=file` that go into the campaign's file
ANY_SPEED = (0.0, 1e6)  # rpm


@dataclass(frozen=True)
class Next:
    """Next step in words, its command, and the files by name that it needs."""

    steps: tuple[str, ...]
    command: str
    files: Mapping[str, bytes]

    @property
    def text(self) -> str:
        return "\n".join(["Next:", *(f"  {line}" for line in (*self.steps, self.command))])

    def to_data(self) -> dict[str, Any]:
        return {"steps": list(self.steps), "command": self.command}


def next_measurement(plan: Plan, cell: Cell, run: str, output: Path) -> Next | None:
    """Next step from a recommended `run` (as in `measurement.runs`), for a cell with results in `output`.

    None if nothing is recommended, if a label stands for settings of the cell, or if the source of the data is not
    known here.
    """
    source = cell.settings["measurement"]
    if not run or (len(plan.cells) > 1 and "label" in plan.axes):  # a label stands for settings that no command has
        return None
    if source["name"] == "synthetic":
        words = [f"measurement.runs=[{','.join([*(source.get('runs') or [BARE]), run])}]"]
        if directions := source.get("directions"):  # the further run goes as the first
            words.append(f"measurement.directions=[{','.join([*directions, directions[0]])}]")
        return Next((), _command(plan, cell, words), {})
    if source["name"] == "campaign":
        added = f"measure {FURTHER_FILE} and add to {source['path']}: - {_further(run)}"
        return Next((visible(added),), _command(plan, cell, []), {})
    if source["name"] == "file":
        path, beside = from_here(output / CAMPAIGN_FILE), output.absolute()  # '.' has no name
        words = [
            "measurement=campaign",
            path_word("measurement.path", path),
            path_word("output", from_here(beside.with_name(f"{beside.name}_campaign"))),
        ]
        weights = " and ".join(
            f"{each.magnitude / GRAM_MILLIMETRE:.4g} g mm at {each.position:.4g} m, {each.angle / DEGREE:.0f}°"
            for each in weights_of(run)
        )
        of = f"a run with {weights}" if weights else "the run"
        step = f"Measure {of} ({path} describes it), and put its data into {from_here(output / FURTHER_FILE)}; then"
        content = _campaign(source, run, output).encode()
        return Next((visible(step),), _command(plan, cell, words), {CAMPAIGN_FILE: content})
    return None


def _command(plan: Plan, cell: Cell, changes: Sequence[str]) -> str:
    """The command of a cell, quoted for a shell; `changes` replace the arguments that they override."""
    swept = [axis for axis in plan.axes if axis != "samples"] if len(plan.cells) > 1 else []
    words = [*(override(axis, cell.place[axis]) for axis in swept if axis in cell.place), *changes]
    changed = {_key(word) for word in words}
    if "measurement" in changed:
        changed |= {f"measurement.{name}" for name in OF_FILE}
    kept = [word for word in plan.command if _key(word) not in changed]
    return command_line([*kept, *words])


def _key(word: str) -> str:
    return word.partition("=")[0].lstrip("+")


def from_here(path: Path) -> str:
    """A path as it is given in the working directory."""
    return str(path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path)


def _campaign(source: Mapping[str, Any], run: str, output: Path) -> str:
    """The YAML file of a campaign: the measured run of a CSV file, and the one that is to be measured."""
    file = os.path.relpath(Path(source["path"]).expanduser(), output)
    ends = [source.get("speed_from"), source.get("speed_to")]
    speeds = [limit if end is None else end for end, limit in zip(ends, ANY_SPEED)]
    used = f", speeds: [{speeds[0]:g}, {speeds[1]:g}]" if any(ends) else ""
    return f"""\
# The measured run and the run recommended next. Measure the latter with the same probes, add the weight below to the
# shaft, and put its data into {FURTHER_FILE} in the folder of this file. If another weight was used, enter it in a
# copy: the command that wrote this file overwrites it.
# position: m from the left end; angle_deg: from where the phases of the model's unbalance count, towards the direction of
# rotation.
runs:
  - {{name: present, file: {json.dumps(file, ensure_ascii=False)}{used}}}
  - {_further(run)}
"""


def _further(run: str) -> str:
    """The entry of a run that is to be measured."""
    weights = (
        f"{{position: {weight.position:.10g}, g_mm: {weight.magnitude / GRAM_MILLIMETRE:.10g},"
        f" angle_deg: {weight.angle / DEGREE:.10g}}}"
        for weight in weights_of(run)
    )
    return f"{{name: further, file: {FURTHER_FILE}, weights: [{', '.join(weights)}]}}"
