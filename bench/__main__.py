"""Entry of `python -m bench`: the first word is a sub-command, or all words are Hydra's."""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType

BAD_INPUT, INTERRUPTED, TERMINATED = 2, 130, 143

# One BLAS thread per process, set before numpy loads: the cores belong to the workers, which inherit this, and
# sums do not depend on the machine's number of cores.
for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_variable] = "1"


def main() -> int:
    try:
        code = _done()
    except KeyboardInterrupt:  # while modules were imported
        print("interrupted: nothing was begun", file=sys.stderr)
        code = INTERRUPTED
    for number in (signal.SIGINT, signal.SIGTERM):  # all is done: a further one ends what Python tidies up
        signal.signal(number, signal.SIG_DFL)
    if code in (INTERRUPTED, TERMINATED):
        # Python would end with signal 2 in place of this code where an extension module met the interrupt and passed it on.
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
    return code


def _done() -> int:
    from bench.storage.shadowed_packages import hidden

    if line := hidden():
        print(f"error: {line}", file=sys.stderr)
        return BAD_INPUT
    from bench.main import Terminated, run  # after the thread settings and this check: it may load numpy and plugins

    def terminate(number: int, frame: FrameType | None) -> None:
        raise Terminated

    signal.signal(signal.SIGTERM, terminate)
    return run(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main())
