"""Which texts there are besides C and Python for NumPy."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from symbody.codegen.texts import casadi, fortran, jax, julia, matlab
from symbody.codegen.texts.layout import Arguments
from symbody.expr.sequence import Sequence

TEXTS: Final[Mapping[str, Callable[[Sequence, str, Arguments | None], str]]] = {
    "fortran": fortran.generate,
    "matlab": matlab.generate,  # Octave reads it too
    "octave": matlab.generate,
    "julia": julia.generate,
    "jax": jax.generate,
    "casadi": casadi.generate,
}
