from .from_python import Experiment as Experiment
from .from_python import run as run
