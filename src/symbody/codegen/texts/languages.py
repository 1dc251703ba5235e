"""Which texts there are."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from symbody.codegen.texts import c, casadi, fortran, javascript, jax, julia, matlab, python, rust
from symbody.codegen.texts.layout import Arguments
from symbody.expr.sequence import Sequence

TEXTS: Final[Mapping[str, Callable[[Sequence, str, Arguments | None], str]]] = {
    # These two take what the sequence reads; the others all arguments, in their order.
    "c": lambda sequence, name, given: c.generate(sequence, name, has_signals="s" in (given or {})),
    "python": lambda sequence, name, given: python.generate(sequence, name, has_signals="s" in (given or {})),
    "fortran": fortran.generate,
    "matlab": matlab.generate,  # Octave reads it too
    "octave": matlab.generate,
    "julia": julia.generate,
    "rust": rust.generate,
    "javascript": javascript.generate,
    "jax": jax.generate,
    "casadi": casadi.generate,
}
