"""Names of what functions take, and sequences with these names as source text."""

from __future__ import annotations

from dataclasses import dataclass, replace

from symbody.codegen.texts.languages import TEXTS
from symbody.errors import CompileError, Problem, nearest
from symbody.expr.sequences.program import written_out
from symbody.expr.sequences.sequence import Input, Sequence


@dataclass(frozen=True, slots=True)
class Signature:
    """Names of what a function takes, group by group, in order.

    Native code finds the states s of signals behind the coordinates, in one group q.
    """

    q: tuple[str, ...]
    u: tuple[str, ...]
    r: tuple[str, ...]
    p: tuple[str, ...]
    s: tuple[str, ...] = ()

    def names(self, group: str) -> tuple[str, ...]:
        """Return the names of one group of native code."""
        return {"q": self.q + self.s, "u": self.u, "r": self.r, "p": self.p}.get(group, ("t",))

    @property
    def arguments(self) -> tuple[str, ...]:
        """Names of t, coordinates, speeds, inputs, parameters, states of signals."""
        return ("t", *self.q, *self.u, *self.r, *self.p, *self.s)

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states x: speeds, coordinates, states of signals."""
        return self.u + self.q + self.s


def source_text(sequence: Sequence, language: str, signature: Signature | None = None) -> str:
    """Return a sequence as source text.

    Parameters
    ----------
    signature : Signature, optional
        All arguments by name, also those which the sequence does not read.

    Raises
    ------
    CompileError
        If the language is not known.
    """
    word = language.lower() if isinstance(language, str) else language
    if word not in TEXTS:
        is_model = word == "modelica"  # a model has states: more than a sequence
        cure = "write sb.generate_code(eqs, [...], 'modelica')" if is_model else nearest(str(word), TEXTS)
        raise CompileError(
            Problem("compile.unknown_language", "language", f"there is no language {language!r}", "", cure)
        )
    if signature is None:
        return TEXTS[word](written_out(sequence), "f", None)
    arguments = {group: signature.names(group) for group in "qurp"} | {"q": signature.q}
    if signature.s:
        sequence, arguments = _with_signals_apart(sequence, len(signature.q)), arguments | {"s": signature.s}
    return TEXTS[word](written_out(sequence), "f", arguments)


def _with_signals_apart(sequence: Sequence, coordinates: int) -> Sequence:
    """Return a sequence with the states of signals as a group s of their own."""
    inputs = tuple(
        Input(entry.name, "s", entry.position - coordinates)
        if entry.group == "q" and entry.position >= coordinates
        else entry
        for entry in sequence.inputs
    )
    return replace(sequence, inputs=inputs)
