"""The ModelBuilder: a server on this computer, and the page in the browser that it serves."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
