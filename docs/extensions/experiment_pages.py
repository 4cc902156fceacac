"""Settings of a whole experiment and the experiments themselves as Markdown, from conf/."""

from __future__ import annotations

import re
from pathlib import Path

from bench.storage.own_files import CONF
from docstring_text import cell, escaped
from plugin_pages import table

REMARKED = re.compile(r"^(\w+): +(\S.*?) +# (.*)$", re.MULTILINE)
COMMAND = re.compile(r"^ *(?:python -m bench )?(\+experiment=.*)$")


def settings_text() -> str:
    """The settings of conf/config.yaml with their defaults and remarks."""
    found = REMARKED.findall((CONF / "config.yaml").read_text(encoding="utf-8"))
    rows = [(f"`{name}`", f"`{default.strip()}`", cell(remark)) for name, default, remark in found]
    return table(("setting", "default", "is"), rows)


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
