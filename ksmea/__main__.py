"""`python -m ksmea` is `python -m bench`: the command line of the project.

Nothing else in this package knows the bench.
"""
# Shorter than 40 lines: the entry of `python -m ksmea`.

import runpy

runpy.run_module("bench", run_name="__main__", alter_sys=True)
