"""`python -m benchmarks`: computations of this project compared with other programs, in one run.

docs/speed.md explains the result.
"""

import sys

from benchmarks.harness.command import main

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
