"""Allowed imports: the contracts of pyproject.toml."""

import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LINT = "import sys; from importlinter.cli import lint_imports_command; lint_imports_command()"


def lint(config):
    return subprocess.run(
        [sys.executable, "-c", LINT, "--no-cache", "--no-logo", "--config", str(config)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def test_the_contracts_of_the_project_are_kept():
    run = lint(ROOT / "pyproject.toml")
    assert run.returncode == 0, run.stdout + run.stderr
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    for contract in contracts:
        assert f"{contract['name']} KEPT" in run.stdout


def test_a_contract_that_is_broken_is_noticed(tmp_path):
    """The plugins do import the framework: a contract against that must fail, or the test above shows nothing."""
    config = tmp_path / "broken.toml"
    config.write_text(
        "[tool.importlinter]\nroot_packages = ['ksmea', 'optimizers']\n"
        "[[tool.importlinter.contracts]]\nname = 'no framework'\ntype = 'forbidden'\n"
        "source_modules = ['optimizers']\nforbidden_modules = ['ksmea']\n"
    )
    run = lint(config)
    assert run.returncode == 1 and "no framework BROKEN" in run.stdout, run.stdout + run.stderr
