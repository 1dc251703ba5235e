"""Which formulations there are: every class in the files of this folder that is one."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from types import MappingProxyType

from symbody.equations import formulations
from symbody.equations.formulations.formulation import Formulation
from symbody.model.class_folders import snake_case


@cache
def formulation_types() -> Mapping[str, type[Formulation]]:
    """Return every formulation by its word in options, as "newton_euler"."""
    classes = {
        snake_case(value.__name__): value
        for name in sorted(module.name for module in iter_modules(formulations.__path__))
        for value in vars(import_module(f"{formulations.__name__}.{name}")).values()
        if isinstance(value, type) and issubclass(value, Formulation) and value is not Formulation
    }
    return MappingProxyType(classes)
