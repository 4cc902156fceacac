"""Examples in docstrings give what they show."""

import doctest
import re
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FOLDERS = ("bench", "ksmea", "measurements", "optimizers", "problems", "surrogates", "docs/extensions")
WITH_EXAMPLES = [
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removeprefix("docs.extensions.")
    for folder in FOLDERS
    for path in sorted((ROOT / folder).rglob("*.py"))
    if re.search(r'^ *(""")?>>> ', path.read_text(encoding="utf-8"), re.MULTILINE)
]


@pytest.mark.parametrize("name", WITH_EXAMPLES)
def test_examples_give_what_they_show(name, request):
    result = doctest.testmod(import_module(name), extraglobs={"getfixture": request.getfixturevalue})
    assert result.attempted and not result.failed
