"""Tasks for the timing of benchmarks, with what can go wrong."""

import os
import sys
import time

from benchmarks.harness.task import Task


def busy(rounds, value=1.0, quality=None, parts=None, units=1.0):
    """As many rounds of the same arithmetic; its result is `value`, how good it is `quality` of each turn."""

    def run(turn):
        total = 0
        for number in range(rounds):
            total += number * number
        return turn

    return Task(
        run,
        values=None if value is None else lambda turn: [value, 2.0],
        quality=None if quality is None else lambda turn: quality[turn],
        parts=None if parts is None else lambda turn: parts,
        units=units,
    )


def absent():
    import no_such_library

    return no_such_library


def failing():
    def run(turn):
        raise ValueError("no solution\nsecond line")

    return Task(run)


def failing_later():
    def run(turn):
        if turn:
            raise ValueError("not this time")

    return Task(run)


def dying():
    def run(turn):
        print("the last words", file=sys.stderr, flush=True)
        os._exit(3)

    return Task(run)


def hanging():
    return Task(lambda turn: time.sleep(60))


def talkative():
    """Prints to standard output, which carries answers."""
    return Task(lambda turn: print("{}", flush=True))
