"""`python -m benchmarks setup [DIR]`: the environment of the peers.

It has what the extra `peers` of pyproject.toml names.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
import venv
from pathlib import Path

from benchmarks.harness.processes import ROOT
from ksmea.errors import SettingError

VARIABLE = "BENCHMARK_PEERS"  # names the environment's folder
DEFAULT = ROOT / ".peers"


def peers_folder() -> Path:
    """Where the peers are looked for unless a folder is named."""
    return Path(os.environ.get(VARIABLE) or DEFAULT)


def required() -> list[str]:
    """Requirements of the extra."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return list(project["optional-dependencies"]["peers"])


def setup(folder: Path) -> int:
    """Make the environment, or add to it what it lacks; the exit code of pip."""
    if folder.exists() and not (folder / "pyvenv.cfg").is_file() and any(folder.iterdir()):
        raise SettingError(
            f"setup: expected a new folder or an environment, found other files in {folder}; name another one"
        )
    print(f"{folder}: {', '.join(required())}")
    if not (folder / "pyvenv.cfg").is_file():
        venv.create(folder, with_pip=True)
    python = folder / ("Scripts" if sys.platform == "win32" else "bin") / "python"
    return subprocess.run([str(python), "-m", "pip", "install", "-q", *required()], check=False).returncode
