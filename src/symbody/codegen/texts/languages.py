"""Which texts there are."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

import symbody.codegen.texts as texts
from symbody.codegen.texts.layout import Arguments
from symbody.expr.sequences.sequence import Sequence

# A language is imported when a text in it is asked for.
TEXTS: Final[Mapping[str, Callable[[Sequence, str, Arguments | None], str]]] = {
    # These two take what the sequence reads; the others all arguments, in their order.
    "c": lambda sequence, name, given: texts.c.generate(sequence, name, has_signals="s" in (given or {})),
    "python": lambda sequence, name, given: texts.python.generate(
        sequence, name, has_signals="s" in (given or {})
    ),
    "fortran": lambda *given: texts.fortran.generate(*given),
    "matlab": lambda *given: texts.matlab.generate(*given),  # Octave reads it too
    "octave": lambda *given: texts.matlab.generate(*given),
    "julia": lambda *given: texts.julia.generate(*given),
    "rust": lambda *given: texts.rust.generate(*given),
    "javascript": lambda *given: texts.javascript.generate(*given),
    "jax": lambda *given: texts.jax.generate(*given),
    "casadi": lambda *given: texts.casadi.generate(*given),
}
