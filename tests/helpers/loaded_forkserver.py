"""The fork server of multiprocessing as a fork of a process that has its modules.

No new Python imports them, so that a command's workers start in milliseconds. The fork stands by from before the command and has nothing
of it.
"""

import fcntl
import json
import os
import signal
import socket
import sys
import traceback
from multiprocessing import util

SERVER = "from multiprocessing.forkserver import main"  # how the command line of a server begins
LONGEST = 1 << 20  # bytes of a message
MOST_PASSED = 8  # descriptors
ABOVE = 100  # descriptors that the server is to have by number are below


def stand_by():
    """Fork the process that becomes this one's first fork server; later ones are started as ever."""
    if sys.platform != "linux":
        return
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    number = os.fork()
    if number == 0:
        ours.close()
        become_server(theirs)
    theirs.close()
    start_anew, owner = util.spawnv_passfds, os.getpid()

    def start(path, args, passed):
        if not args[-1].startswith(SERVER) or os.getpid() != owner or ours.fileno() < 0:
            return start_anew(path, args, passed)
        asked = {
            "code": args[-1],
            "numbers": passed,
            "cwd": os.getcwd(),
            "environment": dict(os.environ),
            "blocked": [int(each) for each in signal.pthread_sigmask(signal.SIG_BLOCK, ())],
        }
        with ours:
            socket.send_fds(ours, [json.dumps(asked).encode()], passed)
        return number

    util.spawnv_passfds = start


def become_server(theirs):
    """Wait for what a new Python would be given, and execute it; end if the command has ended."""
    try:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        message, received, *_ = socket.recv_fds(theirs, LONGEST, MOST_PASSED)
        theirs.close()
        if not message:
            os._exit(0)
        asked = json.loads(message)
        os.chdir(asked["cwd"])
        os.environ.clear()
        os.environ.update(asked["environment"])
        above = [fcntl.fcntl(each, fcntl.F_DUPFD, ABOVE) for each in received]
        for each in received:
            os.close(each)
        for number, each in zip(asked["numbers"], above, strict=True):
            os.dup2(each, number)
            os.close(each)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.pthread_sigmask(signal.SIG_SETMASK, asked["blocked"])
        exec(asked["code"], {"__name__": "__main__"})  # noqa: S102 – as python -c would
    except SystemExit:  # its clients have ended
        os._exit(0)
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(1)
