"""The door: `python -m bench`. The first word is a sub-command, or all words are Hydra's."""

from __future__ import annotations

import os
import sys

from bench.storage.siblings import hidden

BAD_INPUT = 2

# One BLAS thread per process, set before numpy loads: the cores belong to the workers, which inherit this, and
# sums do not depend on the machine's number of cores.
for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_variable] = "1"


def main() -> int:
    if line := hidden():
        print(f"error: {line}", file=sys.stderr)
        return BAD_INPUT
    from bench.door import run  # after the thread settings and this check: it loads numpy and the plugins

    return run(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main())
