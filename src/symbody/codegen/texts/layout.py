"""What the texts of all languages agree on: names, sizes of arguments, and the comment at the head."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from collections.abc import Sequence as Items
from dataclasses import dataclass
from typing import Final

from symbody.codegen.identifiers import assign_identifiers, quote_name
from symbody.codegen.pieces import Plan, plan_pieces
from symbody.errors import CompileError, Problem
from symbody.expr.sequences.sequence import Output, Sequence

Arguments = Mapping[str, Items[str]]

WORDS: Final = {
    "t": "time", "q": "coordinates", "u": "speeds", "r": "inputs", "p": "parameters", "c": "constants",
    "s": "states of signals",
}  # fmt: skip
WHOLE: Final = 2**62  # a piece size that no sequence reaches

_FUNCTION_NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,40}")
_VALUE: Final = re.compile(r"z\d+(_\d+)?", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Language:
    """Which words a language keeps for itself.

    Attributes
    ----------
    title : str
        As its users write it.
    words : frozenset of str
        Keywords, and what the text itself uses.
    any_case : bool
        Whether case does not count; then `words` are in lower case.
    """

    title: str
    words: frozenset[str]
    any_case: bool = False

    def is_reserved(self, word: str) -> bool:
        """Return whether a name of the user must not be `word`."""
        known = word.lower() if self.any_case else word
        return known in self.words or _VALUE.fullmatch(word) is not None or known.startswith("symbody_")


@dataclass(frozen=True, slots=True)
class TextLayout:
    """A sequence and its names in one text.

    Attributes
    ----------
    name : str
        Name of the function.
    sizes : mapping of group to int
        How many numbers an argument has; groups in the order of the call, c only if it is read, s only if
        there are any.
    words : tuple of str
        Identifiers of the inputs of the sequence.
    results : tuple of str
        Identifiers of its outputs; all identifiers differ, also where case does not count.
    """

    sequence: Sequence
    plan: Plan
    name: str
    sizes: Mapping[str, int]
    labels: Mapping[str, Items[str]]
    words: tuple[str, ...]
    results: tuple[str, ...]

    @classmethod
    def for_sequence(
        cls,
        sequence: Sequence,
        name: str,
        language: Language,
        arguments: Arguments | None = None,
        piece_size: int = WHOLE,
    ) -> TextLayout:
        """Return the layout of a text.

        Parameters
        ----------
        arguments : mapping of group to names, optional
            All arguments in order, for those that the sequence does not read.

        Raises
        ------
        CompileError
            If `name` cannot name a function, the sequence calls functions the user supplied, or a constant
            is beyond the doubles.
        """
        _check_name(name, language)
        plan = plan_pieces(sequence, piece_size)
        labels = _labels(sequence, arguments or {})
        own = name.lower()
        outputs = [output.name for output in sequence.outputs]
        words = assign_identifiers(
            [*outputs, *(entry.name for entry in sequence.inputs)],
            lambda word: language.is_reserved(word) or word.lower() in (own, "s" if "s" in labels else own),
        )
        count = len(outputs)
        sizes = {group: len(names) for group, names in labels.items()}
        return cls(sequence, plan, name, sizes, labels, tuple(words[count:]), tuple(words[:count]))

    def heading(self, entry: Callable[[str, int], str], call: str) -> Iterator[str]:
        """Yield the lines at the head of the text: the call, arguments and results with places and names.

        Parameters
        ----------
        entry : callable
            How entry k of a group is written, counted from 0.
        call : str
            How the function is called.
        """
        sequence = self.sequence
        yield f"{call}: {sequence.output_size} numbers in {sequence.operation_count} operations."
        yield "Written by symbody from a model; all numbers are doubles."
        if self.plan.results:
            yield "Where a linear system has no solution, what depends on it is nan."
        sizes = (f"{group} {WORDS[group]} ({size})" for group, size in self.sizes.items() if group != "t")
        yield f"Arguments: t time, {', '.join(sizes)}"
        yield "Entries: place, identifier (- if not read), name"
        read = {(i.group, i.position): word for i, word in zip(sequence.inputs, self.words, strict=True)}
        for group, names in self.labels.items():
            for k, label in enumerate(names):
                word = read.get((group, k), "-")
                yield f"  {entry(group, k)}  {word if group != 't' else 't'}  {quote_name(label)}"
        yield "Results: identifier, shape, name"
        for output, word in zip(sequence.outputs, self.results, strict=True):
            yield f"  {word}  {shape_text(output)}  {quote_name(output.name)}"

    def targets(self, entry: Callable[[str, tuple[int, ...]], str]) -> dict[int, str]:
        """Return where each number of the output goes, as `entry` writes an identifier and indices from 0."""
        places: list[str] = []
        for output, word in zip(self.sequence.outputs, self.results, strict=True):
            places += [entry(word, indices) for indices in _indices(output.shape)]
        return dict(enumerate(places))


def shape_text(output: Output) -> str:
    """Return the shape of an output for comments."""
    return " x ".join(str(size) for size in output.shape) or "number"


def _indices(shape: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
    """Yield all indices, the last one running fastest."""
    found: list[tuple[int, ...]] = [()]
    for size in shape:
        found = [(*before, k) for before in found for k in range(size)]
    yield from found


def _labels(sequence: Sequence, arguments: Arguments) -> dict[str, list[str]]:
    there = {"c": sequence.group_size("c") > 0, "s": "s" in arguments or sequence.group_size("s") > 0}
    groups = [group for group in WORDS if there.get(group, True)]
    labels = {}
    for group in groups:
        size = 1 if group == "t" else sequence.group_size(group)
        names = [*arguments.get(group, ())]
        rest = ["t"] if group == "t" else [f"{group}{k}" for k in range(len(names), size)]
        labels[group] = names + rest
    for entry in sequence.inputs:
        labels[entry.group][entry.position] = entry.name
    return labels


def _check_name(name: str, language: Language) -> None:
    if not _FUNCTION_NAME.fullmatch(name) or language.is_reserved(name):
        raise CompileError(
            Problem("compile.name", "",
                    f"{quote_name(name)} cannot be the name of a {language.title} function",
                    "not an identifier, longer than 41 letters, or taken", "choose another, such as 'f'")
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class TextWriter:
    """Writes the text of a sequence in one language.

    Attributes
    ----------
    language : Language
    write : callable
        The whole text of a layout.
    piece_size : int
        About how many operations go into one function.
    """

    language: Language
    write: Callable[[TextLayout], str]
    piece_size: int = WHOLE

    def __call__(
        self,
        sequence: Sequence,
        name: str = "f",
        arguments: Arguments | None = None,
        *,
        piece_size: int | None = None,
    ) -> str:
        """Return the text.

        Parameters
        ----------
        name : str
            Name of the function.
        arguments : mapping of group to names, optional
            All arguments in order, for those that the sequence does not read.
        piece_size : int, optional
            Otherwise than the language has it; results do not depend on it.

        Raises
        ------
        CompileError
            If `name` cannot name a function, the sequence calls functions the user supplied, or a constant
            is beyond the doubles.
        """
        size = self.piece_size if piece_size is None else piece_size
        return self.write(TextLayout.for_sequence(sequence, name, self.language, arguments, size))
