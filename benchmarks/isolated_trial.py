"""A trial in a process of its own, within limits of time and memory."""

from __future__ import annotations

import json
import os
import resource
import select
import signal
from collections.abc import Callable
from dataclasses import dataclass

LONGEST_DETAIL = 3000  # characters that are kept, from the end


@dataclass(frozen=True)
class Outcome:
    """What a file did: `fine`, `refused` and the like, or a fault; `detail` is its last words."""

    ending: str
    detail: str = ""


def isolated(trial: Callable[[], Outcome], seconds: int, n_byte: int) -> Outcome:
    """The outcome of a trial: `hang` past so many seconds, `died` where its process ends without one."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        resource.setrlimit(resource.RLIMIT_AS, (n_byte, n_byte))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        outcome = trial()
        with open(writing, "w") as pipe:
            json.dump([outcome.ending, outcome.detail[-LONGEST_DETAIL:]], pipe)
        os._exit(0)
    os.close(writing)
    with open(reading) as pipe:
        ready = select.select([pipe], [], [], seconds)[0]
        if not ready:
            os.kill(child, signal.SIGKILL)
        answer = pipe.read() if ready else ""
    _, code = os.waitpid(child, 0)
    if not ready:
        return Outcome("hang", f"more than {seconds} s")
    return Outcome(*json.loads(answer)) if answer else Outcome("died", f"signal or code {code}")
