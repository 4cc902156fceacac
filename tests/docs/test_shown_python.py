"""Python blocks of the pages are Python, and what they import from this project is there. Some are run: by test_readme.py, the
tutorial's and the contest's tests."""

import ast
from importlib import import_module

import pytest

from shown_pages import ROOT, blocks, pages, text_of

OURS = ("bench", "ksmea", "measurements", "optimizers", "problems", "surrogates")
SHOWN = [
    pytest.param(code, id=f"{page.relative_to(ROOT)}-{number}")
    for page in pages()
    for number, code in enumerate(blocks(text_of(page), "python"))
]


@pytest.mark.parametrize("code", SHOWN)
def test_what_a_block_imports_is_there(code):
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.ImportFrom) and node.module.split(".")[0] in OURS:
            module = import_module(node.module)
            assert [alias.name for alias in node.names if not hasattr(module, alias.name)] == []
        elif isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.split(".")[0] in OURS:
                    import_module(alias.name)


@pytest.mark.parametrize("code", SHOWN)
def test_functions_of_the_door_are_there(code):
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in ("ksmea", "bench"):
            assert hasattr(import_module(node.value.id), node.attr), f"{node.value.id}.{node.attr}"
