"""The YAML file of a campaign.

Its runs, where their data lie and which known weights the shaft carried.

`measurements/campaign.py` says what the keys mean; each error names the place in the file.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ksmea.measurement.campaign import RUN_DIRECTIONS, Plane, UnknownWeight, Weight, WeightUnit
from ksmea.settings.document import Block
from ksmea.units import DEGREE, GRAM_MILLIMETRE
from measurements.balancing_planes import Stated, read_planes, read_size, stated

OWN = "own"
SIZES = {"g_mm", "size"}  # of a known weight
NOISES = ("shared", OWN)  # whether runs have the same noise, or each its own
MAX_RUNS = 100
MAX_ANGLE = 360.0  # degrees
NAME = re.compile(r"[\w.-]+")  # of a run; an unknown of its own is called name@run


@dataclass(frozen=True)
class RunEntry:
    """A run as the file describes it: speeds in rpm, None if all of its file are used."""

    block: Block
    name: str
    file: str  # of its data, from the working directory
    weights: tuple[Weight, ...]
    weight_units: tuple[WeightUnit, ...]
    unknown_weights: tuple[UnknownWeight, ...]
    direction: str
    speed_from: float | None
    speed_to: float | None


@dataclass(frozen=True)
class Document:
    """A campaign as its file describes it; `is_one_file`: its column `run` names the run of each row."""

    runs: tuple[RunEntry, ...]
    own: tuple[str, ...]
    has_own_noise: bool
    is_one_file: bool
    planes: tuple[Plane, ...]


def read_document(block: Block) -> Document:
    """The campaign that a file describes."""
    is_one_file = "file" in block.values
    block.check_keys(["runs"], ["file", "own", "noise", "planes"])
    has_own_noise = "noise" in block.values and block.choice("noise", "noise", NOISES) == OWN
    blocks = block.blocks("runs")
    if len(blocks) > MAX_RUNS:
        raise block.error("runs", f"expected at most {MAX_RUNS}, got {len(blocks)}; leave some out")
    planes = block.blocks("planes") if "planes" in block.values else []
    of_planes = stated(planes)
    runs = [_run(each, block if is_one_file else each, is_one_file, of_planes) for each in blocks]
    names = [run.name for run in runs]
    for run in runs:
        if names.count(run.name) > 1:
            raise block.error(
                "runs", f"expected each name once, got {run.name} {names.count(run.name)} times; rename one"
            )
    weights = [pair for run in runs for pair in zip(run.weights, run.weight_units)]
    return Document(tuple(runs), _own(block), has_own_noise, is_one_file, read_planes(planes, weights, of_planes))


def _run(block: Block, of_file: Block, is_one_file: bool, of_planes: Mapping[float, Stated]) -> RunEntry:
    required = ["name"] if is_one_file else ["name", "file"]
    block.check_keys(required, ["weights", "direction", "speeds"])
    name = block.text("name")
    if not NAME.fullmatch(name):
        raise block.error("name", f"expected letters, digits, _ . and - alone, got {name!r}; rename the run")
    weights = block.blocks("weights") if block.values.get("weights", []) != [] else []
    known = [_weight(each, of_planes) for each in weights if SIZES & each.values.keys()]
    low, high = _speeds(block)
    return RunEntry(
        block,
        name,
        str(Path(block.file).parent / Path(of_file.text("file")).expanduser()),
        tuple(weight for weight, _ in known),
        tuple(unit for _, unit in known),
        tuple(_unknown_weight(each, of_planes) for each in weights if not SIZES & each.values.keys()),
        block.choice("direction", "direction", RUN_DIRECTIONS) if "direction" in block.values else "",
        low,
        high,
    )


def _weight(block: Block, of_planes: Mapping[float, Stated]) -> tuple[Weight, WeightUnit]:
    block.check_keys(["position", "g_mm" if "g_mm" in block.values else "size"], ["angle_deg"])
    angle = 0.0
    if "angle_deg" in block.values:
        angle = block.number("angle_deg", "deg", at_least=-MAX_ANGLE, at_most=MAX_ANGLE)
    position = block.number("position", "m")
    if "size" in block.values:
        size, unit = read_size(block, "size", of_planes.get(position))
    else:
        size, unit = block.number("g_mm", "g mm", above=0) * GRAM_MILLIMETRE, WeightUnit()
    return Weight(position, size, angle * DEGREE), unit


def _unknown_weight(block: Block, of_planes: Mapping[float, Stated]) -> UnknownWeight:
    block.check_keys(["position"], ["at_most_g_mm", "at_most", "g_mm", "size", "angle_deg"])
    if "angle_deg" in block.values:
        raise block.error("angle_deg", "expected g_mm with it; a weight of unknown size has no known angle: omit it")
    position, at_most = block.number("position", "m"), None
    if "at_most_g_mm" in block.values:
        at_most = block.number("at_most_g_mm", "g mm", above=0) * GRAM_MILLIMETRE
    elif "at_most" in block.values:
        at_most, _ = read_size(block, "at_most", of_planes.get(position))
    return UnknownWeight(position, at_most)


def _speeds(block: Block) -> tuple[float | None, float | None]:
    if "speeds" not in block.values:
        return None, None
    ends = block.entries("speeds")
    if len(ends) != 2:
        raise block.error("speeds", f"expected [from, to] in rpm, got {len(ends)} numbers")
    pair = Block(block.file, block.path, {"speeds from": ends[0], "speeds to": ends[1]})
    low = pair.number("speeds from", "rpm", at_least=0)
    return low, pair.number("speeds to", "rpm", above=low)


def _own(block: Block) -> tuple[str, ...]:
    if block.values.get("own", []) == []:
        return ()
    names = block.entries("own")
    for name in names:
        if not isinstance(name, str) or names.count(name) > 1:
            raise block.error("own", f"expected names of unknowns, each once, got {name!r}")
    return tuple(names)
