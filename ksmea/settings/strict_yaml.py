"""YAML in which a value is a number, a text, nothing, a list or a mapping.

It is never something else by surprise.

PyYAML follows YAML 1.1, where 2e11 is a text, 010 is eight, 1:30 is ninety and `no` is false. Here a number is what
a calculator takes for one, and a key that stands twice in a mapping is an error instead of the last one winning.

By hand, since readers of YAML 1.2 still surprise: ruamel.yaml makes dates and is slower, yaml12 takes the last of two keys and dies of
nested aliases, yamlcore has no merges; all read `true` and 0x10 as other things than texts, to any depth.
"""

from __future__ import annotations

import re
from typing import Any

import yaml

from ksmea.errors import SettingError, shortened
from ksmea.settings.regular_files import read_input

LARGEST = 2 * 10**5  # bytes; a rotor with a thousand disks needs half of it, and a second or two to be read
LONGEST_MESSAGE = 200  # characters of PyYAML's own words
DEEPEST = 20  # lists and mappings within each other; a rotor has four


def read_bytes(path: str) -> bytes:
    """Content of a file; the error says why it cannot be read."""
    return read_input(
        path, "YAML", LARGEST, f"expected at most {LARGEST} bytes, got {{}}; a description is smaller".format
    )


def parse(content: bytes, path: str) -> Any:
    """The value that a YAML document holds; `path` names it in errors.

    >>> parse(b"{modulus: 2e11, held: no, count: 010}", "example.yaml")
    {'modulus': 200000000000.0, 'held': 'no', 'count': 10}
    """
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise SettingError(f"{path}: expected a YAML text in UTF-8, got other bytes at {error.start}") from error
    try:
        return yaml.load(text, Loader=StrictLoader)
    except yaml.MarkedYAMLError as error:
        where = f" line {error.problem_mark.line + 1}" if error.problem_mark else ""
        raise SettingError(f"{path}{where}: expected YAML, got {_in_words(error)}") from error
    except (yaml.YAMLError, ValueError, TypeError, OverflowError, AttributeError, LookupError) as error:
        # but for the first: an explicit tag (!!int, !!timestamp) that does not fit its value
        raise SettingError(f"{path}: expected YAML, got {_one_line(error)}") from error
    except RecursionError as error:
        raise SettingError(f"{path}: expected a description, got lists nested too deeply") from error


class StrictLoader(yaml.SafeLoader):
    """PyYAML's safe loader without the surprises named above."""

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012 – PyYAML's own way to say which plain words are no texts
    depth = 0  # of the node that is being read

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        peek: Any = self.peek_event
        if self.depth >= DEEPEST:
            raise yaml.composer.ComposerError(
                None,
                None,
                f"lists nested too deeply, more than {DEEPEST} within each other",
                peek().start_mark,
            )
        self.depth += 1
        node = super().compose_node(parent, index)
        self.depth -= 1
        return node

    def flatten_mapping(self, node: yaml.MappingNode) -> None:
        """Keys of the mapping itself come before merged ones.

        If two merges bring one key, it is an error.
        """
        own = [pair for pair in node.value if pair[0].tag != MERGE]
        super().flatten_mapping(node)
        given = {key.value for key, _ in own if isinstance(key, yaml.ScalarNode)}
        merged: list[tuple[yaml.ScalarNode, yaml.Node]] = []
        for key, value in node.value[: len(node.value) - len(own)]:  # PyYAML puts merged ones first
            if not isinstance(key, yaml.ScalarNode) or key.value in given:
                continue
            if key.value in (other.value for other, _ in merged):
                problem = f"the key '{shortened(key.value)}' from two merges (<<); merge one mapping alone"
                raise yaml.constructor.ConstructorError(None, None, problem, key.start_mark)
            merged.append((key, value))
        node.value = merged + own

    def construct_mapping(self, node: Any, deep: bool = False) -> dict[Any, Any]:
        if isinstance(node, yaml.MappingNode):
            seen = set()
            for key in (key for key, _ in node.value if isinstance(key, yaml.ScalarNode)):
                if key.value in seen:
                    raise yaml.constructor.ConstructorError(
                        None, None, f"the key '{shortened(key.value)}' a second time", key.start_mark
                    )
                seen.add(key.value)
        return super().construct_mapping(node, deep)


def _whole(loader: Any, node: Any) -> int:
    return int(loader.construct_scalar(node))


def _decimal(loader: Any, node: Any) -> float:
    return float(loader.construct_scalar(node))


INTEGER, FLOAT, NULL, MERGE = (f"tag:yaml.org,2002:{name}" for name in ("int", "float", "null", "merge"))
NUMBER_STARTS = list("+-.0123456789")
StrictLoader.add_implicit_resolver(INTEGER, re.compile(r"[-+]?[0-9]+$"), NUMBER_STARTS)
StrictLoader.add_implicit_resolver(
    FLOAT, re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?$"), NUMBER_STARTS
)
StrictLoader.add_implicit_resolver(NULL, re.compile(r"(~|null)?$"), ["", "~", "n"])
StrictLoader.add_implicit_resolver(MERGE, re.compile(r"<<$"), ["<"])
StrictLoader.add_constructor(INTEGER, _whole)
StrictLoader.add_constructor(FLOAT, _decimal)


def _in_words(error: yaml.MarkedYAMLError) -> str:
    """Description of an error with its place; PyYAML's words for text that is not YAML."""
    said = _one_line(error.problem).removeprefix("found ")
    if isinstance(error, (yaml.scanner.ScannerError, yaml.parser.ParserError)):
        return f"a syntax error ({said}); look there and just above for a missing bracket, quote, colon or space"
    return said


def _one_line(message: object) -> str:
    return shortened(str(message), LONGEST_MESSAGE)
