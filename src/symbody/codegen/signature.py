"""Names of what functions take, and sequences with these names as source text."""

from __future__ import annotations

from dataclasses import dataclass

from symbody.codegen.texts.languages import TEXTS
from symbody.errors import CompileError, Problem, nearest
from symbody.expr.program import written_out
from symbody.expr.sequence import Sequence


@dataclass(frozen=True, slots=True)
class Signature:
    """Names of what a function takes, group by group, in order."""

    q: tuple[str, ...]
    u: tuple[str, ...]
    r: tuple[str, ...]
    p: tuple[str, ...]

    def names(self, group: str) -> tuple[str, ...]:
        """Return the names of one group."""
        return {"q": self.q, "u": self.u, "r": self.r, "p": self.p}.get(group, ("t",))


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
        cure = nearest(str(word), TEXTS)
        raise CompileError(
            Problem("compile.unknown_language", "language", f"there is no language {language!r}", "", cure)
        )
    arguments = {group: signature.names(group) for group in "qurp"} if signature is not None else None
    return TEXTS[word](written_out(sequence), "f", arguments)
