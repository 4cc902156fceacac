"""`new optimizer NAME`: a package with a plugin of one's own to begin with, its tests next to it.

With `--file` the plugin's file alone. Both are the project's example of that kind under another name.
"""

from __future__ import annotations

import re
from importlib.util import find_spec
from pathlib import Path

from bench.storage.own_files import EXAMPLES
from ksmea.errors import SettingError, unknown
from ksmea.plugins import registry
from ksmea.plugins.files import snake_case

FILE = "--file"
NAME = re.compile(r"[a-z][a-z0-9_]*")
DATA = "measurement.relative=0.05 repetitions=2"
FIRST_RUN = {  # words that choose a plugin of each kind
    "effect": f"method=direct optimizer=lm measurement.kind=complex measurement.hidden=[NAME] {DATA}",
    "method": f"method=NAME optimizer=lm {DATA}",
    "optimizer": f"method=direct optimizer=NAME {DATA}",
    "problem": f"method=direct optimizer=lm problem=NAME {DATA}",
    "surrogate": f"surrogate=NAME samples=40 {DATA}",
}


def new(words: list[str]) -> int:
    """Write the files, and print what to do with them."""
    asked = [word for word in words if word != FILE]
    if len(asked) != 2:
        raise SettingError(
            f"new: expected a kind of plugin and a name, as new optimizer my_search, got {len(asked)} words"
        )
    group, name = asked
    if group not in FIRST_RUN:
        raise unknown("kind of plugin:", group, FIRST_RUN)
    _require_usable(group, name)
    [test] = (EXAMPLES / group).glob("test_*.py")
    example = test.stem.removeprefix("test_")
    sources = [f"{example}.py"] if FILE in words else ["pyproject.toml", f"{example}.py", test.name]
    folder = Path() if FILE in words else Path(name)
    written = {folder / source.replace(example, name): EXAMPLES / group / source for source in sources}
    for path in written:
        if path.exists():
            raise SettingError(f"new: expected no {path} yet, found one; choose another name, or remove it")
    for path, source in written.items():
        path.parent.mkdir(exist_ok=True)
        path.write_text(_renamed(source.read_text(encoding="utf-8"), example, name), encoding="utf-8")
        print(f"written: {path}")
    print(f"try it:  python -m bench plugins=[{folder / name}.py] {FIRST_RUN[group].replace('NAME', name)}")
    if FILE not in words:
        print(f"or:      pip install -e {name}; python -m pytest {name}; python -m bench help {group} {name}")
    return 0


def _require_usable(group: str, name: str) -> None:
    """Raise `SettingError` if a plugin, its class and its module cannot have a name."""
    if not NAME.fullmatch(name) or snake_case(_of_class(name)) != name:
        raise SettingError(f"new: expected a name in snake case, as my_search, got {name}; choose another one")
    if name in registry.registered(group):
        raise SettingError(
            f"new: {group}={name} is there already, from {registry.origin(group, name)}; choose another name"
        )
    if find_spec(name) is not None:
        raise SettingError(f"new: there is a Python module {name} already; choose another name")


def _of_class(name: str) -> str:
    return "".join(word.capitalize() for word in name.split("_"))


def _renamed(text: str, example: str, name: str) -> str:
    """A file of an example with its module, class and package under another name."""
    for spelt in (str, _of_class, lambda each: each.replace("_", "-")):
        text = text.replace(spelt(example), spelt(name))
    return text
