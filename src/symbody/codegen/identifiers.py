"""Names of users as identifiers of a programming language, and as text in its comments.

A name in a model is any text. Nothing of it reaches generated code except through these functions.
"""

from __future__ import annotations

import json
import re
import unicodedata
from collections.abc import Callable, Iterable
from typing import Final

MAX_LENGTH: Final = 63  # the significant letters of C99, Fortran and MATLAB

_GREEK: Final = dict(
    zip(
        "αβγδεζηθικλμνξοπρστυφχψω",
        "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi omicron pi rho sigma tau "
        "upsilon phi chi psi omega".split(),
        strict=True,
    )
) | {"ς": "sigma", "ϑ": "theta", "ϕ": "phi", "ϵ": "epsilon", "ϱ": "rho", "ϖ": "pi"}


def assign_identifiers(names: Iterable[str], is_reserved: Callable[[str], bool]) -> list[str]:
    """Return an identifier for each of `names`, in order.

    Identifiers are of letters, digits and single underscores, begin with a letter and differ from each
    other even where case does not count. A name that is one already and not reserved keeps itself,
    unless an equal one came before. The result depends on nothing but the arguments.

    Parameters
    ----------
    is_reserved : callable
        Whether a word must not be used; false for words that begin with ``x_``, but for a few.

    >>> assign_identifiers(["a b", "a_b", "θ₁", "for"], lambda word: word == "for")
    ['a_b_2', 'a_b', 'theta1', 'x_for']
    """
    wanted = list(names)
    stems = [_stem(name) for name in wanted]
    stems = [f"x_{stem}"[:MAX_LENGTH].rstrip("_") if is_reserved(stem) else stem for stem in stems]
    result = [""] * len(wanted)
    taken: set[str] = set()
    for k, (name, stem) in enumerate(zip(wanted, stems, strict=True)):
        if name == stem and stem.lower() not in taken:
            result[k] = stem
            taken.add(stem.lower())
    tried: dict[str, int] = {}
    for k, stem in enumerate(stems):
        if result[k]:
            continue
        candidate = stem
        # Every M_... may be reserved where M is not: no count would lead out of that.
        base = f"x_{stem}" if is_reserved(f"{stem}_2") else stem
        while is_reserved(candidate) or candidate.lower() in taken:
            tried[stem] = tried.get(stem, 1) + 1
            suffix = f"_{tried[stem]}"
            candidate = base[: MAX_LENGTH - len(suffix)].rstrip("_") + suffix
        result[k] = candidate
        taken.add(candidate.lower())
    return result


def quote_name(name: str) -> str:
    r"""Return `name` in ASCII between double quotes, harmless in comments and strings of any language.

    It is a JSON string in which slashes and question marks are escaped too: no bracket of a comment, no
    trigraph, no line end and no character that changes the direction of writing can appear.

    >>> print(quote_name("θ */ \n"))
    "\u03b8 *\u002f \n"
    """
    text = json.dumps(name)
    for character in "/?\x7f":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def _stem(name: str) -> str:
    """Return the nearest legal identifier; several names may share one."""
    spelled = "".join(_spell(letter) for letter in name[: 2 * MAX_LENGTH])
    plain = unicodedata.normalize("NFKD", spelled).encode("ascii", "ignore").decode("ascii")
    words = re.sub(r"[^A-Za-z0-9]+", "_", plain).strip("_")
    if not words or words[0].isdigit():
        words = f"x{words}"
    return words[:MAX_LENGTH].rstrip("_")


def _spell(letter: str) -> str:
    if letter in _GREEK:
        return _GREEK[letter]
    if letter.lower() in _GREEK:
        return _GREEK[letter.lower()].capitalize()
    # What has no ASCII equivalent separates words; accents, which decompose, do not.
    if unicodedata.normalize("NFKD", letter).isascii() or unicodedata.combining(letter):
        return letter
    head = unicodedata.normalize("NFKD", letter)[0]
    return letter if head.isascii() else "_"
