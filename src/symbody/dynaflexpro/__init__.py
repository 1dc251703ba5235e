"""The words of DynaFlexPro, for its scripts typed in Python: indices from 0, formulas from SymPy.

Nothing is computed here that the rest of the package does not compute.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
