"""Experiment files of one's own after slips of a pen or an editor, drawn from a seed."""

import random
import re

HEALTHY = """# @package _global_
# Which optimiser, at which noise?
defaults:
  - override /problem: three_disk
  - override /optimizer: de
name: mine
output: results/${name}
repetitions: 2
seed: 1
workers: null
timeout: 60.0
figures: [updates]
measurement:
  relative: 0.05
  kind: ${oc.env:NO_SUCH_VARIABLE,complex}
problem:
  limits: {kxx: [10, 100]}
  sensors: [0.1, 0.5]
standard:
  optimizer.population: 20
  optimizer.de.generations: 5
cross:
  - {method: direct}
grid:
  - {label: DE, optimizer: de, samples: [25, 30]}
  - {label: PSO, optimizer: pso, measurement.floor: 0.1}
"""
TOKENS = [
    *(
        "null",
        "~",
        "true",
        "no",
        "[]",
        "{}",
        "[1, 2]",
        "{a: 1}",
        "[[de]]",
        "[null]",
        "''",
        "???",
        "NaN",
        ".inf",
        "-1",
        "0",
        "1e400",
    ),
    *(
        "1,5",
        "0x10",
        "2020-01-01",
        "de",
        "dee",
        "nowhere.py",
        "a/b",
        "..",
        "x" * 300,
        "*a",
        "&a [*a]",
        "!!python/name:os.system",
    ),
    *(
        "!!binary aGk=",
        "!!set {a}",
        "${",
        "${name",
        "${nowhere}",
        "${name}",
        "${oc.env:NOPE}",
        "${foo:1}",
        "'${${name}}'",
        "$",
        "\\${a}",
    ),
    *(
        "[" * 3000,
        "[" * 3000 + "]" * 3000,
        "{a: " * 50 + "1" + "}" * 50,
        '"\\ud800"',
        '"\\e[31m"',
        "µ",
        "=1+2",
        "- a",
        "a: b: c",
        "<<",
    ),
]
LINES = [
    *(
        "name: other",
        "_target_: os.system",
        "hydra: 3",
        "hydra: {launcher: {_target_: os.nope}}",
        "hydra: {run: {dir: 3}}",
        "<<: {name: a}",
    ),
    *(
        "3: 4",
        "null: 1",
        "[1]: 2",
        "true: 1",
        "study: null",
        "optimizer: [de]",
        "grid: null",
        "add: [null]",
        "includes: [mine]",
        "plugins: 3",
    ),
    *(
        "defaults: 3",
        "  - null",
        "  - [1]",
        "  - {optimizer: null}",
        "  - {optimizer: {a: 1}}",
        "  - {1: 2}",
        "  - mine",
        "  - {a: {b: c}}",
    ),
    *(
        "---",
        "# @package foo",
        "\ttab: 1",
        "label: [1]",
        "paper: table3",
        "table: nope",
        "own_seeds: 3",
        "share: [nope]",
        "batches: 1e9",
    ),
]


def mutated(seed):
    """The file after one to three slips, as bytes."""
    draw = random.Random(seed)
    content = HEALTHY.encode()
    for _ in range(draw.choice((1, 1, 2, 3))):
        content = draw.choice((_token, _token, _token, _line, _line, _cut, _byte, _twice))(draw, content)
    return content


def _token(draw, content):
    spans = [found.span() for found in re.finditer(rb"(?<=[ \[,{-])[\w$][^,}\]\n:]*|^\w+", content, re.MULTILINE)]
    start, end = draw.choice(spans or [(0, 0)])
    return content[:start] + draw.choice(TOKENS).encode() + content[end:]


def _line(draw, content):
    lines = content.splitlines(keepends=True)
    lines.insert(draw.randint(0, len(lines)), draw.choice(LINES).encode() + b"\n")
    return b"".join(lines)


def _twice(draw, content):
    lines = content.splitlines(keepends=True) or [b""]
    lines.insert(draw.randint(0, len(lines)), draw.choice(lines))
    return b"".join(lines)


def _cut(draw, content):
    at = draw.randint(0, len(content))
    return content[:at] + content[at + draw.choice((1, 5, 50)) :]


def _byte(draw, content):
    at = draw.randint(0, len(content))
    return content[:at] + bytes([draw.randint(0, 255)]) + content[at + draw.randint(0, 1) :]
