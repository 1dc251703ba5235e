"""`gap_words`: what sentences say of a rope, a stop or a contact, taut or closed, slack or open."""

from __future__ import annotations

from dataclasses import dataclass

from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.unilateral import element_words


@dataclass(frozen=True, slots=True)
class GapWords:
    """What sentences say of a unilateral element: a rope, a stop or a contact in a point.

    Attributes
    ----------
    subject : str
        Kind and name.
    holds, open : str
        What it is while its row holds, and while it does not.
    at_gap_zero : str
        What it is where its gap is 0, regardless of its effort.
    without_effort : str
        What it is where its gap is 0 and nothing acts; and what it does to small deviations.
    impossible : str
        What it would need where its gap is negative.
    too_far : str
        That its gap is negative.
    wrong_way : str
        What it would have to do where its effort is negative.
    force : str
        The word for its effort.
    effort_unit : str
        "" where it is not known.
    share : str
        What a gap is a share of; "" if it has no length to be compared with.
    """

    subject: str
    holds: str
    open: str
    at_gap_zero: str
    without_effort: str
    impossible: str
    too_far: str
    wrong_way: str
    force: str
    effort_unit: str
    share: str

    def with_effort(self, effort: float) -> str:
        """Return what it is with its effort."""
        return f"{self.subject} is {self.holds} with {effort + 0.0:.6g}{self._unit()}"

    def describe_wrong_way(self, effort: float) -> str:
        """Return that its effort would have to be negative."""
        return f"{self.subject} would have to {self.wrong_way} with {-effort:.4g}{self._unit()}"

    def open_by(self, share: float, before: str) -> str:
        """Return that it is open, and of a rope by how much of its length."""
        between = before if before.startswith(",") else f" {before}"
        if not self.share:
            return self.open if before.startswith(",") else f"{self.open} {before}"
        return f"{self.open}{between} by {share:.3g} {self.share}"

    def _unit(self) -> str:
        return f" {self.effort_unit}" if self.effort_unit else ""


def gap_words(eqs: EquationSet, name: str) -> GapWords:
    """Return the words for a rope, a stop or a contact of some equations."""
    kind, shown = element_words(eqs.formed, name)
    subject = f"{kind} {shown}"
    if kind == "rope":
        return GapWords(
            subject, "taut", "slack", "at its full length",
            "at its length without tension: it pulls for small deviations to one side only",
            "the rope would have to be longer", f"the ends of {subject} are farther apart than its length",
            "push", "tension", "N", "of its length",
        )  # fmt: skip
    unit = "N" if kind == "contact" else eqs.units.get(f"opening_effort {name}", "")
    return GapWords(
        subject, "closed", "open", "at gap 0",
        "closed without effort: it acts on small deviations to one side only",
        "its gap would have to be negative", f"the gap of {subject} is negative",
        "pull", "effort", unit, "",
    )  # fmt: skip
