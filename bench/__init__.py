"""Experiments: runs planned from a configuration, computed by workers, and made into tables.

`bench.run` runs one from Python.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
