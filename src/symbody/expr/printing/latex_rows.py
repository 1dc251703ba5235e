r"""LaTeX of whole pages: equations below each other in ``aligned``, long sides broken into rows."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

WIDTH: Final = 80  # letters of a row, about what a page holds
_TOKEN: Final = re.compile(
    r"\\(?:left|right)\s*(?:\\[a-zA-Z]+ ?|.)|\\(?:begin|end)\{[a-z]+\*?\}| [+-] |\\[a-zA-Z]+ ?|\\.|.",
    re.DOTALL,
)
_SIGNS: Final = frozenset((" + ", " - "))
# What takes no room of its own, and commands that stand for several letters.
_INVISIBLE: Final = re.compile(
    r"[{}_^&\s]|\\[,;!]|\\(?:left|right|Big[lr]|mathrm|operatorname|frac|d?dot|begin|end)\b"
)
_COMMAND: Final = re.compile(r"\\[a-zA-Z]+|\\.")
_FUNCTION: Final = re.compile(r"\\(?:arc)?(?:sin|cos|tan|exp|log|min|max)h?\b")


@dataclass(frozen=True, slots=True)
class _Tokens:
    """A formula in tokens, with the depth of brackets at each, and the partner of each bracket.

    Attributes
    ----------
    texts : tuple of str
        Commands with their brackets, signs between terms, single characters.
    depths : tuple of int
        How many brackets are open; -1 inside braces and environments, which cannot be broken.
    partners : dict of int to int
        The index of the closing bracket for that of each opening one.
    """

    texts: tuple[str, ...]
    depths: tuple[int, ...]
    partners: dict[int, int]


def latex_equations_page(
    blocks: Sequence[Sequence[tuple[str, str]]], width: int = WIDTH, signs: Sequence[Mapping[int, str]] = ()
) -> str:
    r"""Return blocks of equations, pairs of sides, as one ``aligned`` environment without delimiters.

    They are aligned at their signs, or at their beginnings where a left side takes several rows.

    Parameters
    ----------
    signs : sequence of mapping of int to str
        For each of the blocks the signs that are not "=", by the place of the equation.
    """
    broken = [
        [
            (break_latex(a, width), break_latex(b, width), signs[n].get(k, "=") if n < len(signs) else "=")
            for k, (a, b) in enumerate(block)
        ]
        for n, block in enumerate(blocks)
        if block
    ]
    at_signs = all(len(left) == 1 for block in broken for left, _, _ in block)
    bodies = [
        " \\\\\n".join(row for parts in block for row in _rows(*parts, at_signs, width)) for block in broken
    ]
    return "\\begin{aligned}\n" + " \\\\[1ex]\n".join(bodies) + "\n\\end{aligned}"


def _rows(left: Sequence[str], right: Sequence[str], sign: str, at_signs: bool, width: int) -> Iterator[str]:
    if at_signs:
        yield f"{left[0]} &{sign} {right[0]}"
        yield from (rf"&\quad {{}}{row}" for row in right[1:])
        return
    indented = [left[0], *(rf"\quad {{}}{row}" for row in left[1:])]
    yield from (f"&{row}" for row in indented[:-1])
    if letters(left[-1]) + letters(right[0]) > width:
        yield f"&{indented[-1]}"
        yield rf"&\qquad {{}}{sign} {right[0]}"
    else:
        yield f"&{indented[-1]} {sign} {right[0]}"
    yield from (rf"&\qquad\quad {{}}{row}" for row in right[1:])


def letters(formula: str) -> int:
    r"""Return about how many letters wide LaTeX is set.

    >>> letters(r"\ddot{\theta_{2}} + \cos\left(x\right)")
    9
    """
    plain = _INVISIBLE.sub("", _FUNCTION.sub("fun", formula))
    return len(_COMMAND.sub("x", plain))


def break_latex(formula: str, width: int = WIDTH) -> list[str]:
    r"""Return the rows of a formula, each of at most `width` letters where its terms allow it.

    Sides are broken in front of the signs of their terms; a term that is itself too long is broken inside
    its brackets, which are then of one fixed size, because ``\left`` and ``\right`` must share a row.
    """
    if letters(formula) <= width:
        return [formula]
    tokens = _tokenize(formula)
    pieces = list(_pieces(tokens, 0, len(tokens.texts), 0, width))
    rows, filled = [pieces[0]], _length(tokens, *pieces[0])
    for start, stop in pieces[1:]:
        length = _length(tokens, start, stop)
        if filled + length > width:
            rows.append((start, stop))
            filled = length
        else:
            rows[-1] = (rows[-1][0], stop)
            filled += length
    return [_write(tokens, start, stop) for start, stop in rows]


def _tokenize(formula: str) -> _Tokens:
    texts = tuple(_TOKEN.findall(formula))
    depths, partners, opened, closed_in = [], {}, [], 0
    for k, text in enumerate(texts):
        if text == "{" or text.startswith("\\begin"):
            closed_in += 1
        elif text == "}" or text.startswith("\\end"):
            closed_in -= 1
        elif text.startswith("\\left") and not text.startswith("\\lefta"):
            opened.append(k)
        elif text.startswith("\\right") and not text.startswith("\\righta"):
            partners[opened.pop()] = k
        depths.append(-1 if closed_in else len(opened))
    return _Tokens(texts, tuple(depths), partners)


def _pieces(tokens: _Tokens, start: int, stop: int, depth: int, width: int) -> Iterator[tuple[int, int]]:
    """Return where the terms stand; those that are too long are split further."""
    signs = [k for k in range(start + 1, stop) if tokens.texts[k] in _SIGNS and tokens.depths[k] == depth]
    bounds = [start, *signs, stop]
    deepest = max(tokens.depths[start:stop], default=0)
    for first, last in zip(bounds, bounds[1:], strict=False):
        if depth < deepest and _length(tokens, first, last) > width:
            yield from _pieces(tokens, first, last, depth + 1, width)
        else:
            yield first, last


def _length(tokens: _Tokens, start: int, stop: int) -> int:
    return letters("".join(tokens.texts[start:stop]))


def _write(tokens: _Tokens, start: int, stop: int) -> str:
    """Return a row; brackets whose partner stands in another row get a fixed size."""
    closing = {close: start_of for start_of, close in tokens.partners.items()}
    texts = list(tokens.texts[start:stop])
    for k in range(start, stop):
        if k in tokens.partners and tokens.partners[k] >= stop:
            texts[k - start] = "\\Bigl" + tokens.texts[k].removeprefix("\\left")
        elif k in closing and closing[k] < start:
            texts[k - start] = "\\Bigr" + tokens.texts[k].removeprefix("\\right")
    return "".join(texts).strip()
