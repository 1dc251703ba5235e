"""Names of symbols taken apart for print: a head, which may be a Greek letter, and indices."""

from __future__ import annotations

import re
from typing import Final

# Letters by their names in LaTeX; Alpha, Beta and the like are Latin capitals there. A parameter
# called pi is not among them: it is not the constant.
GREEK: Final = dict(
    zip(
        "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi rho sigma tau upsilon phi "
        "chi psi omega Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega".split(),
        "αβγδεζηθικλμνξρστυφχψωΓΔΘΛΞΠΣΥΦΨΩ",
        strict=True,
    )
)


def name_words(name: str) -> list[str]:
    """Return the head of a name and its indices: after ``_``, and of final digits.

    A name that begins or ends with ``_``, or has two in a row, is one word.

    Examples
    --------
    >>> name_words("beta_1"), name_words("m1"), name_words("lambda_rod_2"), name_words("_x")
    (['beta', '1'], ['m', '1'], ['lambda', 'rod', '2'], ['_x'])
    """
    head, *indices = name.split("_")
    split = re.fullmatch(r"([^\W\d_]+)([0-9]+)", head)
    if split is not None:
        head, indices = split[1], [split[2], *indices]
    return [head, *indices] if head and all(indices) else [name]


def greek_name(name: str) -> str:
    """Return a name whose head is the name of a Greek letter with that letter.

    Examples
    --------
    >>> greek_name("theta1"), greek_name("lambda_C_1"), greek_name("thetas")
    ('θ1', 'λ_C_1', 'thetas')
    """
    head = name_words(name)[0]
    return GREEK[head] + name.removeprefix(head) if head in GREEK else name
