"""Plugins of all kinds that change, break or end their process, each next to a healthy one."""

HEAD = """
import multiprocessing, os, signal, subprocess, sys, time, warnings
from dataclasses import dataclass

import numpy as np

import ksmea
from ksmea import Method, Objective, Optimizer, Predictor, Surrogate, setting
from ksmea.plugins.source import MeasurementSource, ProblemSettings
from ksmea.identification.direct import Direct
from ksmea.settings.settings import part
from measurements.synthetic import Synthetic
from problems.three_disk import ThreeDisk
from surrogates.rsm import ResponseSurface
"""
OPTIMIZER = '''
@dataclass(frozen=True)
class Bad(Optimizer):
    """Misbehaves."""

    {settings}

    def minimize(self, objective, rng):
        {doing}
        objective(rng.random((20, objective.dim)))
        return objective.result()
'''
SURROGATE = '''
@dataclass(frozen=True)
class Bad(ResponseSurface):
    """Misbehaves."""

    {settings}

    def fit(self, u, y, rng):
        {doing}
        return super().fit(u, y, rng)
'''
PROBLEM = '''
@dataclass(frozen=True)
class Bad(ThreeDisk):
    """Misbehaves."""

    {settings}

    def build(self):
        {doing}
        return super().build()
'''
SOURCE = '''
@dataclass(frozen=True)
class Bad(Synthetic):
    """Misbehaves."""

    {settings}

    def measure(self, *given):
        {doing}
        return super().measure(*given)
'''
METHOD = '''
@dataclass(frozen=True)
class Bad(Method):
    """Misbehaves."""

    optimizer: Optimizer = part("what searches")
    {settings}

    def identify(self, *given):
        {doing}
        return Direct(self.optimizer).identify(*given)
'''
EFFECT = '''
from problems.effects.mass import Mass


@dataclass(frozen=True)
class Bad(Mass):
    """Misbehaves."""

    {settings}

    def added_to(self, problem):
        {doing}
        return super().added_to(problem)
'''
KINDS = {
    "optimizer": OPTIMIZER,
    "surrogate": SURROGATE,
    "problem": PROBLEM,
    "measurement": SOURCE,
    "method": METHOD,
    "effect": EFFECT,
}
WHILE_IT_RUNS = {  # what it does, and whether its own runs have results then
    "patches numpy": (
        "np.linalg.solve = np.linalg.lstsq = np.sum = lambda *a, **k: 1 / 0; np.random.default_rng = None",
        None,
    ),
    "patches the project": ("Objective.__call__ = lambda self, u: 0 / 0; ksmea.Direct = None", None),
    "leaves the folder": ("os.chdir('/')", True),
    "changes the environment": ("os.environ.clear(); os.environ['OMP_NUM_THREADS'] = '9'", True),
    "raises at every rounding": ("np.seterr(all='raise')", None),
    "turns warnings into errors": ("warnings.simplefilter('error')", None),
    "leaves children": ("[subprocess.Popen(['sleep', '300']) for _ in range(2)]", True),
    "starts a pool": ("list(multiprocessing.Pool(2).map(abs, range(4)))", True),
    "forks": ("os.fork() or os._exit(0)", True),
    "exits": ("sys.exit(3)", False),
    "ends the process": ("os._exit(3)", False),
    "crashes": ("os.kill(os.getpid(), signal.SIGSEGV)", False),
    "raises": ("raise RuntimeError('out of order')", False),
    "ignores signals": ("[signal.signal(n, signal.SIG_IGN) for n in (signal.SIGTERM, signal.SIGUSR1)]", True),
    "closes its streams": ("sys.stdout = sys.stderr = None", True),
    "drops modules": ("[sys.modules.pop(n) for n in [*sys.modules] if n.startswith(('scipy', 'problems'))]", None),
}
AT_IMPORT = {  # what it does while it is imported, and what the reason says if it is left out then
    "patches numpy": ("np.linalg.solve = np.sum = lambda *a, **k: 1 / 0", ""),
    "patches the project": ("Objective.__call__ = lambda self, u: 0 / 0", ""),
    "leaves the folder": ("os.chdir('/')", ""),
    "changes the environment": ("os.environ['PYTHONPATH'] = '/nowhere'; os.environ['OMP_NUM_THREADS'] = '9'", ""),
    "raises at every rounding": ("np.seterr(all='raise')", ""),
    "raises": ("raise RuntimeError('no licence')", "RuntimeError: no licence"),
    "exits": ("sys.exit('no licence')", "SystemExit: no licence"),
    "hangs": ("time.sleep(300)", "its import did not end within"),
    "crashes": ("os.kill(os.getpid(), signal.SIGSEGV)", "its import ended the process by SIGSEGV"),
    "ends the process": ("os._exit(5)", "its import ended the process by exit code 5"),
}
IN_SETTINGS = {  # what its settings are, and what the reason says
    "check raises": ("def check(self): raise ZeroDivisionError('no')", "got ZeroDivisionError: no"),
    "check exits": ("def check(self): sys.exit(2)", "got SystemExit: 2"),
    "check ends the process": ("def check(self): os._exit(3)", "ended the process by exit code 3"),
    "is called name": ("name: str = setting('x', 'a name')", "expected another name of a setting than 'name'"),
    "is called check": ("check: str = setting('x', 'a name')", "expected another name of a setting than 'check'"),
    "has no type": ("size: 'Unknown' = setting(1, 'a size')", "expected types of its settings that can be resolved"),
    "has no default": ("size: int = setting(None, 'a size')", "expected a setting of type"),
}


def source(kind, doing="pass", settings="pass", at_import="", name="Bad"):
    """The text of a plugin's file."""
    text = KINDS[kind].format(doing=doing, settings=settings).replace("class Bad(", f"class {name}(")
    return f"{HEAD}{at_import}\n{text}"
