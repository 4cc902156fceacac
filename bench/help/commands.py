"""Help on a command: its line of the first page, and the docstring of its module.

The module is not imported for that.
"""
# Shorter than 40 lines: completion uses it, and may load nothing large.

from __future__ import annotations

import ast
import re

from bench.storage.own_files import PACKAGE

LINE = re.compile(r"^python -m bench ([a-z]+)\b.*$", re.MULTILINE)
WITHOUT_MODULE = {  # commands that have no module of their own
    "help": "Whatever has a name: help status, help table3, help optimizer, help de, help samples, help optimizer.population."
    " Limits of an effect on a problem: help effect runout problem=rk4. With plugins=[my_optimizer.py] on plugins of plain files"
    " too, with --config-dir DIR on experiments there.",
    "completion": 'In ~/.bashrc: eval "$(ksmea-bench completion bash)". In ~/.zshrc, behind compinit: eval "$(ksmea-bench completion'
    ' zsh)". Completed are commands, experiments, groups, plugins, settings, choices, and folders of results.',
}
MODULES = {
    "import": ("import_file", "import_rotor")
}  # of a command whose name is a word of Python, and that takes two kinds of file


def command_names(usage: str) -> list[str]:
    """The commands that the first page has a line for."""
    return list(dict.fromkeys(LINE.findall(usage)))


def command_text(name: str, usage: str) -> str:
    """The line of a command, and what it does."""
    lines = [found[0] for found in LINE.finditer(usage) if found[1] == name]
    paths = [PACKAGE / "commands" / f"{module}.py" for module in MODULES.get(name, (name,))]
    said = WITHOUT_MODULE.get(name) or "\n\n".join(
        ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "" for path in paths
    )
    return "\n".join([*lines, "", said, "", "-q shows only errors, -v tracebacks too."])
