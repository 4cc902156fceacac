"""One BLAS thread per process, set before numpy loads: the cores belong to the processes that the tests run in."""

import os

# As bench/__main__.py does for its workers, so that those of this process compute the same to the last digit.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

collect_ignore = ["helpers/run_ups_by_ross.py"]  # needs the extra `peers`, as tests/test_peer_data.py says
