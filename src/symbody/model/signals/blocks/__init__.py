"""Blocks, one family a file: each is nothing but the signals that it expands into."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
