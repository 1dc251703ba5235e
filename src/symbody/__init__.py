"""Symbolic multibody dynamics: model file, readable equations, fast code, motion.

The names below are listed in the order of the flow in ``__init__.pyi`` and load on first use,
so that ``import symbody`` costs nothing.
"""

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
