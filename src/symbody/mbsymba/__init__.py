"""The words of MBSymba, for its scripts typed in Python: frames, points, vectors and equations by hand.

Expressions in and out are SymPy's, functions of time are ``dynamicsymbols``. The rest of
the package computes.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
