"""Compressed plotting library (plotly.js) for pages that must work when mailed alone.

Inlined as it is it takes 4.8 MB, compressed and in base64 2.0 MB. Browsers have unpacked that themselves since 2023
(`DecompressionStream`).
"""

from __future__ import annotations

import base64
import gzip
import hashlib
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from ksmea.errors import SettingError

ASSETS = Path(__file__).parent / "assets"

LEVEL = 6  # of compression: 9 is 0.2 % smaller


@cache
def packed() -> str:
    """The library, compressed, in base64; the same for the same version of plotly."""
    return in_text(_library())


def in_text(data: bytes) -> str:
    """Data as a page's script unpacks them: compressed, in base64."""
    return base64.b64encode(gzip.compress(data, LEVEL, mtime=0)).decode()


@cache
def digest() -> str:
    """Digest of the unpacked library for a page's security policy."""
    return digest_of(_library())


def digest_of(script: bytes) -> str:
    """A script as a content security policy names it."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(script).digest()).decode()}'"


@cache
def asset(name: str) -> str:
    """A file of `assets/`."""
    return (ASSETS / name).read_text(encoding="utf-8")


def _library() -> bytes:
    """The file of the package, which is found without importing it."""
    found = find_spec("plotly")
    if found is None or found.origin is None:
        raise SettingError("pages: expected the package plotly, found none; install the dependencies of pyproject.toml")
    return (Path(found.origin).parent / "package_data" / "plotly.min.js").read_bytes()
