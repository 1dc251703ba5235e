r"""Files: models from and to TOML, read without running anything.

A file that cannot be read tells what is wrong, on which line, and what to write instead:

>>> from symbody.formats import model_from_toml
>>> model_from_toml('name = "empty"\n[[body]]\nnam = "Mass"', where="a.toml")
Traceback (most recent call last):
    ...
symbody.errors.FormatError: [file.missing_key] a.toml:2, body 1, name: 'name' is missing
  fix: add name = ..
[file.unknown_key] a.toml:3, body 1, nam: there is no key 'nam' here
  fix: did you mean 'name'?
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
