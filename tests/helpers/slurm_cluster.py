"""A real Slurm of four nodes on this machine, for the tests of one session.

No accounting, no other user, no network.
"""

import os
import shutil
import signal
import socket
import subprocess
import time
from contextlib import contextmanager, suppress

PROGRAMS = ("slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel")
CONFIGURATION = """\
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmUser=root
SlurmdUser=root
AuthType=auth/none
CredType=cred/none
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool.%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
ReturnToService=2
KillWait=5
MinJobAge=86400
NodeName=n[1-4] NodeHostname={host} NodeAddr=127.0.0.1 Port=[{first}-{last}] CPUs=1 RealMemory=4000 State=UNKNOWN
PartitionName=debug Nodes=n[1-4] Default=YES MaxTime=INFINITE State=UP
"""


def why_not():
    """Why no cluster can be started here; empty where one can."""
    if missing := [name for name in PROGRAMS if shutil.which(name) is None]:
        return f"Slurm is not installed (no {missing[0]}); Debian: apt-get install slurmctld slurmd slurm-client"
    return "" if os.getuid() == 0 else "slurmd needs root"


@contextmanager
def cluster(folder):
    """Start the daemons; the environment by which Slurm's commands find them is set meanwhile."""
    for name in ("state", "spool.n1", "spool.n2", "spool.n3", "spool.n4"):
        (folder / name).mkdir(parents=True)
    ports = _free_ports(5)
    text = CONFIGURATION.format(
        folder=folder, host=socket.gethostname().partition(".")[0], port=ports[0], first=ports[1], last=ports[4]
    )
    (folder / "slurm.conf").write_text(text)
    before = os.environ.get("SLURM_CONF")
    os.environ["SLURM_CONF"] = str(folder / "slurm.conf")
    try:
        for command in (["slurmctld"], *(["slurmd", "-N", f"n{number}"] for number in (1, 2, 3, 4))):
            subprocess.run(command, check=True)
        wait_until(lambda: slurm("sinfo", "-h", "-N", "-o", "%t").split() == ["idle"] * 4, "four nodes are idle")
        yield
    finally:
        subprocess.run(["scancel", "--user=root"], check=False)
        with suppress(AssertionError):  # daemons that end first would leave what watches the jobs behind
            wait_until(lambda: not slurm("squeue", "-h"), "all jobs are gone", seconds=20)
        for path in folder.glob("*.pid"):
            os.kill(int(path.read_text()), signal.SIGKILL if "slurmd" in path.name else signal.SIGTERM)
        os.environ.pop("SLURM_CONF")
        if before is not None:
            os.environ["SLURM_CONF"] = before


def _free_ports(count):
    """Neighbouring ports that nobody listens at."""
    for first in range(16817, 17817, count):
        try:
            for port in range(first, first + count):
                with socket.socket() as probe:
                    probe.bind(("127.0.0.1", port))
        except OSError:
            continue
        return range(first, first + count)
    raise AssertionError("no free ports")


def slurm(*words):
    return subprocess.run(words, check=True, capture_output=True, text=True).stdout


def wait_until(condition, what, seconds=300):
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, f"waited {seconds} s until {what}"
        time.sleep(0.2)
