"""Commands of the bench, each in a fork of one process that has imported the bench.

They are as `python -m bench` without the imports.

The process is a server, started as `python loaded_bench.py`. It executes no command itself, so that each fork has the empty
caches of a new process, and what a command changes ends with its fork. Figures are empty files unless they are to be drawn.
Tests of imports, signals or streams start Python itself.
"""

import atexit
import json
import os
import pkgutil
import signal
import subprocess
import sys
from contextlib import suppress
from importlib import import_module
from pathlib import Path

import bench
from loaded_forkserver import stand_by

PACKAGES = ("bench", "measurements", "optimizers", "problems", "surrogates")
TOO_LONG = -signal.SIGALRM  # exit code of a command that does not end within its time


class LoadedBench:
    """The server from outside; `end` it."""

    def __init__(self, environment):
        self._process = subprocess.Popen(
            [sys.executable, __file__],
            cwd="/",
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def call(self, words, cwd, environment, folder, timeout, draws):
        """Exit code, output and errors of `python -m bench WORDS`.

        The streams are files of the folder meanwhile.
        """
        out, err = Path(folder, "out"), Path(folder, "err")
        asked = {"words": words, "cwd": str(cwd), "environment": environment, "timeout": timeout, "draws": draws}
        print(json.dumps(asked | {"out": str(out), "err": str(err)}), file=self._process.stdin, flush=True)
        code = int(self._process.stdout.readline())
        assert code != TOO_LONG, f"did not end within {timeout} s: {words}"
        return code, out.read_text(encoding="utf-8"), err.read_text(encoding="utf-8")

    def end(self):
        self._process.stdin.close()
        self._process.wait(timeout=30)
        self._process.stdout.close()


def serve():
    """Import the bench; then a fork for each line of the input, and its exit code as a line of the output."""
    import_everything()
    for line in sys.stdin:
        child = os.fork()
        if child == 0:
            end(enter(**json.loads(line)))
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)


def import_everything():
    import_module("bench.__main__")  # first, as it sets how many threads numpy has
    for package in PACKAGES:
        for module in pkgutil.walk_packages(import_module(package).__path__, f"{package}."):
            with suppress(ImportError):  # of a package of an extra, which may not be here
                if not module.name.endswith("__main__"):
                    import_module(module.name)


def enter(words, cwd, environment, timeout, draws, out, err):
    """The start of Python for `-m bench`, and the bench."""
    signal.alarm(timeout)  # which ends a process that has not asked for it
    for number, path in enumerate((os.devnull, out, err)):
        opened = os.open(path, os.O_RDWR | os.O_CREAT | os.O_TRUNC)
        os.dup2(opened, number)
        os.close(opened)
    os.chdir(cwd)
    os.environ.clear()
    os.environ.update(environment)
    before = [path for path in environment.get("PYTHONPATH", "").split(os.pathsep) if path]
    sys.path[:1] = [str(cwd), *before]
    if not draws:
        bench.reports.collect._png = lambda chart: b""
    stand_by()
    sys.argv = [bench.__main__.__file__, *words]
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[variable] = "1"  # as the import of the entry does
    return bench.__main__.main()


def end(code):
    """End this process as Python does, but for the destruction of each module."""
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


if __name__ == "__main__":
    serve()
    end(0)
