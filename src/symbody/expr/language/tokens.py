"""Text to tokens; what cannot be one is passed on to `foreign` for an explanation."""

from __future__ import annotations

import re
import unicodedata
from typing import Final, NamedTuple

from symbody.errors import ExpressionError, Problem
from symbody.expr.language.caret import Source, printable
from symbody.expr.language.foreign import character_problem, mark_problem

MAX_LENGTH: Final = 65_536  # characters
MAX_TOKENS: Final = 20_000
MAX_NAME: Final = 128
MAX_PROBLEMS: Final = 10

KEYWORDS: Final = frozenset({"if", "and", "or", "not"})

_TOKEN: Final = re.compile(
    r"(?P<space>[ \t\r\n]+)"
    r"|(?P<number>(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"|(?P<name>[A-Za-z_\u0080-\U0010ffff][0-9A-Za-z_\u0080-\U0010ffff]*)"
    r"|(?P<mark>//|<<|>>|<>|->|=>|=<|&&|\|\||:=)"  # never legal; reported as one token
    r"|(?P<operator>\*\*|<=|>=|==|!=|[-+*/^()<>,])"
    r"|(?P<other>.)",
    re.DOTALL,
)
_OUTPUT: Final = re.compile(r"'[^'\r\n]+'")
# Words or a word with low lines: what outputs are called, as against strings of programs.
_OUTPUT_NAME: Final = re.compile(r"'[a-z]+[ _][^'\r\n]+'")
# What opens a Python string when a quote follows at once; after any other name a quote is a prime.
_STRING_PREFIX: Final = re.compile(r"(?:[fru]|br|rb|fr|rf|b)?", re.IGNORECASE)
# Characters that count as letters or marks and yet show nothing: fillers, joiners, variation selectors.
_INVISIBLE: Final = re.compile(
    "[\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180f\u3164\ufe00-\ufe0f\uffa0\U000e0100-\U000e01ef]"
)


class Token(NamedTuple):
    """A piece of text.

    Attributes
    ----------
    kind : str
        ``"number"``, ``"name"``, ``"output"``, ``"operator"`` (brackets, comma and keywords too), ``"bad"``
        or ``"end"``.
    text : str
        As written, except that ``^`` is ``**`` and an output lacks its quotes.
    start, end : int
        Half-open range in the text, counted from 0.
    """

    kind: str
    text: str
    start: int
    end: int


def normalize(text: str) -> str:
    """Return `text` with harmless variants of characters replaced by the plain ones.

    Full-width and small forms of digits, operators and brackets become ASCII, U+2212 becomes a
    minus, every kind of blank a space, and letters are composed (NFC). Letters of other alphabets
    or styles stay, so two names that look different remain two names. Names of a model are to
    pass through here as well, so that expressions find them.
    """
    if text.isascii():
        return text
    composed = unicodedata.normalize("NFC", text)
    return composed.translate({ord(c): _plain(c) for c in set(composed) if not c.isascii()})


def is_name(text: str) -> bool:
    """Return whether `text`, already normalized, can be written as a name in an expression."""
    found = _TOKEN.fullmatch(text)
    return (
        found is not None
        and found.lastgroup == "name"
        and text not in KEYWORDS
        and len(text) <= MAX_NAME
        and _foreign_letter(text) is None
    )


def tokenize(source: Source) -> tuple[list[Token], list[Problem]]:
    """Return the tokens, closed by one of kind ``"end"``, and what was wrong on the way.

    The text of `source` must be normalized already.

    Raises
    ------
    ExpressionError
        If the text has more than `MAX_LENGTH` characters or `MAX_TOKENS` tokens.
    """
    length = len(source.text)
    if length > MAX_LENGTH:
        raise ExpressionError(_too_large(source, MAX_LENGTH, "characters"))
    tokens: list[Token] = []
    problems: list[Problem] = []
    position = 0
    while position < length and len(problems) < MAX_PROBLEMS:
        token, problem = _next_token(source, position)
        position = token.end
        if token.kind == "space":
            continue
        if len(tokens) == MAX_TOKENS:
            raise ExpressionError(_too_large(source, MAX_TOKENS, "tokens", token.start))
        tokens.append(token)
        if problem is not None:
            problems.append(problem)
    tokens.append(Token("end", "", position, position))
    return tokens, _distinct(problems)


def _distinct(problems: list[Problem]) -> list[Problem]:
    """Return the first problem of each kind, and all that name a character."""
    kinds: dict[str, Problem] = {}
    for problem in problems:
        kinds.setdefault(problem.what if problem.code == "expression.character" else problem.code, problem)
    return list(kinds.values())


def _next_token(source: Source, position: int) -> tuple[Token, Problem | None]:
    found = _TOKEN.match(source.text, position)
    assert found is not None  # the last alternative takes any character
    kind, text, end = found.lastgroup or "", found.group(), found.end()
    if kind == "name":
        return _name(source, text, position)
    if kind == "operator":
        return Token(kind, "**" if text == "^" else text, position, end), None
    if kind not in ("mark", "other"):
        return Token(kind, text, position, end), None
    if source.has_outputs and _OUTPUT.match(source.text, position) and not _is_prime(source.text, position):
        end = source.text.index("'", position + 1) + 1
        return Token("output", source.text[position + 1 : end - 1], position, end), None
    if text in ("'", '"'):
        text, end = _classify_quotation(source.text, position)
    if not text.isprintable():
        return Token("bad", text, position, end), character_problem(source, position)
    return Token("bad", text, position, end), mark_problem(source, position, text)


def _name(source: Source, text: str, start: int) -> tuple[Token, Problem | None]:
    end = start + len(text)
    if len(text) > MAX_NAME:
        problem = source.problem(
            "expression.name_length",
            start + 1,
            f"the name {printable(text)} has {len(text)} characters; the limit is {MAX_NAME}",
            "only generated names, or text without operators, are this long",
            "give the quantity a shorter name",
        )
        return Token("bad", text, start, end), problem
    offset = _foreign_letter(text)
    if offset is not None:
        return Token("bad", text, start, end), character_problem(source, start + offset)
    return Token("operator" if text in KEYWORDS else "name", text, start, end), None


def _is_prime(text: str, place: int) -> bool:
    return place > 0 and (text[place - 1].isalnum() or text[place - 1] in "_)")


def _classify_quotation(text: str, start: int) -> tuple[str, int]:
    """Return the kind of a quotation mark (``"string"``, ``"output"``, ``"prime"``) and where it ends."""
    word = start
    while word > 0 and (text[word - 1].isalnum() or text[word - 1] in "_)"):
        word -= 1
    if text[start] == "'" and _STRING_PREFIX.fullmatch(text, word, start) is None:
        return "prime", start + 1
    closing = text.find(text[start], start + 1)
    kind = "output" if _OUTPUT_NAME.match(text, start) else "string"
    return kind, (len(text) if closing < 0 else closing + 1)


def _plain(character: str) -> str:
    """Return the ASCII form of a character that is nothing but a variant of it."""
    if character == "\N{MINUS SIGN}":
        return "-"
    variant = unicodedata.decomposition(character).startswith(("<wide>", "<small>", "<noBreak>"))
    if not variant and unicodedata.category(character) != "Zs":
        return character
    plain = unicodedata.normalize("NFKC", character)
    is_sign = plain.isascii() and not plain.isalpha() and plain != "_"
    return plain if is_sign else " " if unicodedata.category(character) == "Zs" else character


def _foreign_letter(name: str) -> int | None:
    """Return the place of the first character that no name may contain."""
    if name.isascii():
        return None
    for k, character in enumerate(name):
        legal = character.isidentifier() if k == 0 else f"a{character}".isidentifier()
        # The middle dot is an identifier character of Python's, and a multiplication sign to readers.
        if not legal or character == "\N{MIDDLE DOT}" or _INVISIBLE.match(character):
            return k
    return None


def _too_large(source: Source, limit: int, unit: str, start: int = MAX_LENGTH) -> Problem:
    return source.problem(
        f"expression.too_many_{unit}",
        start + 1,
        f"the expression has more than {limit} {unit}",
        "it was probably generated by a program",
        "define parts of it as parameters and use their names",
    )
