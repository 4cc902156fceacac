"""`python -m benchmarks`: everything computed here beside what else there is, in one run. docs/speed.md says how to read it."""

import sys

from benchmarks.harness.command import main

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
