"""Settings of a whole experiment and the experiments themselves as Markdown, from conf/."""

from __future__ import annotations

import re
import typing
from pathlib import Path

from bench.command_line.bench_settings import BenchConfig, bench_fields
from bench.storage.own_files import CONF
from docstring_text import escaped
from ksmea.plugins.names import GROUPS
from plugin_pages import HEAD, row, table

COMMAND = re.compile(r"^ *(?:python -m bench )?(\+experiment=.*)$")


def settings_text() -> str:
    """The settings of the bench itself."""
    hints = typing.get_type_hints(BenchConfig)
    fields = [field for field in bench_fields().values() if field.name not in GROUPS]
    return table(HEAD, (row(field.name, field, hints[field.name]) for field in fields))


def experiments_text() -> str:
    """A section for each experiment: what it asks, its command and its file."""
    return "\n\n".join(map(_experiment_text, sorted((CONF / "experiment").glob("*.yaml"))))


def _experiment_text(path: Path) -> str:
    lines = path.read_text(encoding="utf-8").splitlines()
    n_remark = next(number for number, line in enumerate(lines[1:]) if not line.startswith("#"))
    remarks = [line.removeprefix("#").removeprefix(" ") for line in lines[1 : n_remark + 1]]
    content = "\n".join([lines[0], *lines[n_remark + 1 :]])
    return f"## {path.stem}\n\n{_remarks(remarks)}\n\n```yaml\n{content}\n```"


def _remarks(lines: list[str]) -> str:
    """Remarks as text, the commands among them as blocks."""
    out: list[str] = []
    for line in lines:
        if command := COMMAND.match(line):
            out.append(f"\n```sh\npython -m bench {command[1]}\n```\n")
        else:
            out.append(escaped(line))
    return "\n".join(out)
