"""One exception root; every message has what is wrong, where, why, and what to do.

A stage that finds several problems raises once with all of them. Exit codes of the command
line follow the class: 2 usage, 3 model, 4 numerics, 5 environment.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from typing import ClassVar, Final

_HOME: Final = os.path.dirname(os.path.abspath(__file__))


@dataclass(frozen=True, slots=True)
class Problem:
    """One fault, described so that the reader can correct it.

    Attributes
    ----------
    code : str
        Stable identifier such as ``"model.duplicate_name"``; documented in ``docs/messages.md``.
    where : str
        Object path or ``file:line`` of the fault, for instance ``"joint slider, axis"``.
    what : str
        The fact, in one sentence.
    why : str
        The likely cause, where it is not plain from `what`.
    fix : str
        What to type instead.

    Examples
    --------
    >>> import symbody as sb
    >>> print(sb.Problem("model.negative_mass", "body Cart", "mass is negative", "", "give 0 or more"))
    [model.negative_mass] body Cart: mass is negative
      fix: give 0 or more
    """

    code: str
    where: str
    what: str
    why: str = ""
    fix: str = ""

    def __str__(self) -> str:
        lines = [f"[{self.code}] {self.where}: {self.what}" if self.where else f"[{self.code}] {self.what}"]
        if self.why:
            lines.append(f"  why: {self.why}")
        if self.fix:
            lines.append(f"  fix: {self.fix}")
        return "\n".join(lines)


class SymbodyError(Exception):
    """Base of all errors that symbody raises for faults of the caller.

    Parameters
    ----------
    *problems : Problem
        All problems of the stage that failed, at least one.

    Examples
    --------
    >>> import symbody as sb
    >>> try:
    ...     sb.Model("cart", [sb.Body("Cart", mass=-1)])
    ... except sb.SymbodyError as error:
    ...     print(error.problems[0].code)
    model.negative_mass
    """

    exit_code: ClassVar[int] = 3

    def __init__(self, *problems: Problem) -> None:
        self.problems: tuple[Problem, ...] = problems
        Exception.__init__(self, *problems)

    def __str__(self) -> str:
        return "\n".join(str(problem) for problem in self.problems)


class UsageError(SymbodyError):
    """A call or a command line for something that does not exist.

    Examples
    --------
    >>> import symbody as sb
    >>> try:
    ...     sb.FixedStep(-0.1)
    ... except sb.UsageError as error:
    ...     print(error.problems[0].code)
    simulation.fixed_step
    """

    exit_code = 2


class CallError(UsageError, TypeError):
    """A call with arguments that a function does not have, or without those that it needs.

    Examples
    --------
    >>> import symbody as sb
    >>> try:
    ...     sb.Body("Cart", mas=1)
    ... except sb.CallError as error:
    ...     print(error)
    [call.unknown_argument] Body: there is no argument 'mas'
      fix: did you mean 'mass'?
    """


class ExpressionError(SymbodyError):
    """Text or an operation that is not a legal expression.

    Examples
    --------
    >>> import symbody as sb
    >>> x, y = (sb.Prismatic(c, "ground", sb.Body(c.upper(), mass=1), axis=c, coordinate=c) for c in "xy")
    >>> ladder = sb.Model("ladder", [x, y, sb.Distance("rod", "X", "Y", 5)], initial={"x": 3, "y": 4})
    >>> try:
    ...     sb.trace_positions(sb.form_equations(ladder), {"x": ["10 dg"]})
    ... except sb.ExpressionError as error:
    ...     print(error.problems[0].code)
    expression.implicit_multiplication
    """


class FormatError(SymbodyError):
    """A file that cannot be read as what it claims to be.

    Examples
    --------
    >>> import symbody as sb
    >>> try:
    ...     sb.load_model("missing.toml")
    ... except sb.FormatError as error:
    ...     print(error.problems[0].code)
    file.missing
    """


class FrameError(SymbodyError):
    """Vectors, points or frames that do not fit together.

    Examples
    --------
    >>> import symbody as sb
    >>> from symbody.spatial import FrameTree
    >>> from symbody.expr.graph import Graph
    >>> try:
    ...     FrameTree(Graph(), {}).depth("Arm")
    ... except sb.FrameError as error:
    ...     print(error.problems[0].code)
    frame.unknown
    """


class ModelError(SymbodyError):
    """A mechanism whose description contradicts itself.

    Examples
    --------
    >>> import symbody as sb
    >>> try:
    ...     sb.Model("cart", [sb.Body("Cart"), sb.Body("Cart")])
    ... except sb.ModelError as error:
    ...     print(error.problems[0].code)
    names.duplicate
    """


class TopologyError(SymbodyError):
    """A choice of trees that does not span the mechanism.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=1), axis="x", coordinate="x")
    >>> try:
    ...     sb.form_equations(sb.Model("cart", [rail]), tree=sb.Trees([], ["other"]))
    ... except sb.TopologyError as error:
    ...     print(error.problems[0].code)
    topology.unknown_joint
    """


class FormulationError(SymbodyError):
    """Equations that cannot be formed as requested.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=1), axis="x", coordinate="x")
    >>> run = sb.simulate(sb.form_equations(sb.Model("cart", [rail])), 1.0)
    >>> try:
    ...     run["kinetic_enrgy"]
    ... except sb.FormulationError as error:
    ...     print(error)
    [equations.unknown_output] kinetic_enrgy: 'kinetic_enrgy' is neither an output nor an expression
      why: there is no symbol 'kinetic_enrgy'
        kinetic_enrgy
        ^
      fix: did you mean 'kinetic_energy' or 'potential_energy'?
    """


class CompileError(SymbodyError):
    """Outputs, parameters or arguments that do not fit a compiled function.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=1), axis="x", coordinate="x")
    >>> eqs = sb.form_equations(sb.Model("cart", [rail]))
    >>> try:
    ...     sb.compile(eqs, "kinetic_energy", parameters={"mas": 2})
    ... except sb.CompileError as error:
    ...     print(error.problems[0].code)
    compile.unknown_parameter
    """


class AssemblyError(SymbodyError):
    """Positions or velocities that cannot satisfy the constraints.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=1), axis="x", coordinate="x")
    >>> try:
    ...     sb.assemble(sb.form_equations(sb.Model("cart", [rail, sb.Constraint("never", "x^2 + 1")])))
    ... except sb.AssemblyError as error:
    ...     print(error.problems[0].code)
    assembly.open
    """

    exit_code = 4


class SimulationError(SymbodyError):
    """A motion that cannot be computed as asked.

    Examples
    --------
    >>> import symbody as sb
    >>> x, y = (sb.Prismatic(c, "ground", sb.Body(c.upper(), mass=1), axis=c, coordinate=c) for c in "xy")
    >>> ladder = sb.Model("ladder", [x, y, sb.Distance("rod", "X", "Y", 5)], initial={"x": 3, "y": 4})
    >>> ratios = sb.velocity_ratios(sb.form_equations(ladder), "x")
    >>> try:
    ...     ratios.at({"x": 5, "y": 0})
    ... except sb.SimulationError as error:
    ...     print(error.problems[0].code)
    kinematics.singular
    """

    exit_code = 4


class TimeLimitError(SymbodyError):
    """Work that takes longer than it was allowed to.

    Attributes
    ----------
    stage : str
        What was under way.
    finished : tuple of (str, float)
        The stages done before, with their seconds.
    notes : tuple of str
        Choices made until then, as `EquationSet.notes`: trees, cut joints, formulation.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=1), axis="x", coordinate="x")
    >>> try:
    ...     sb.form_equations(sb.Model("cart", [rail]), time_limit=1e-9)
    ... except sb.TimeLimitError as error:
    ...     print(error.stage)
    trees
    """

    exit_code = 4

    def __init__(
        self,
        *problems: Problem,
        stage: str = "",
        finished: tuple[tuple[str, float], ...] = (),
        notes: tuple[str, ...] = (),
    ) -> None:
        self.stage = stage
        self.finished = finished
        self.notes = notes
        SymbodyError.__init__(self, *problems)


class EnvironmentFault(SymbodyError):
    """Something this computer lacks: a package, a permission, a file. Its other name is `ResourceError`.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=1), axis="x", coordinate="x")
    >>> try:
    ...     sb.save_report(sb.form_equations(sb.Model("cart", [rail])), "missing/folder/cart.md")
    ... except sb.EnvironmentFault as error:
    ...     print(error.problems[0].code)
    report.unwritable
    """

    exit_code = 5


# Named as the others are; the first name stays, for programs that catch it.
ResourceError = EnvironmentFault


def foreign_cause(error: BaseException) -> BaseException | None:
    """Return the exception behind an error that was raised outside of symbody, as by the caller's function.

    A message of symbody says what was wrong itself: how it was found, in which of its files, is not shown.
    """
    seen = error.__cause__ or (None if error.__suppress_context__ else error.__context__)
    while seen is not None:
        trace, file = seen.__traceback__, ""
        while trace is not None:
            file, trace = trace.tb_frame.f_code.co_filename, trace.tb_next
        if not isinstance(seen, SymbodyError) and not file.startswith(_HOME):
            return seen
        seen = seen.__cause__ or (None if seen.__suppress_context__ else seen.__context__)
    return None


def nearest(name: str, known: Iterable[str], what: str = "names") -> str:
    """Return a "did you mean" sentence for `name`, or a list of what is known.

    A name that differs in capitals alone is nearest.
    """
    names = sorted(set(known))
    same = [word for word in names if word.casefold() == name.casefold()]
    close = same or get_close_matches(name, names, n=3, cutoff=0.6)
    if close:
        return "did you mean " + " or ".join(repr(word) for word in close) + "?"
    if not names:
        return f"leave it out: there are no {what} to choose from."
    shown = ", ".join(names[:20]) + (f", ... ({len(names)} in all)" if len(names) > 20 else "")
    return f"known {what}: {shown}."


def number_in_words(number: int, word: str) -> str:
    """Return a number of things in words.

    >>> number_in_words(1, "body"), number_in_words(2, "body"), number_in_words(0, "degree of freedom")
    ('1 body', '2 bodies', '0 degrees of freedom')
    """
    first, of, rest = word.partition(" of ")
    plural = (f"{first[:-1]}ies" if first.endswith("y") else f"{first}s") + of + rest
    return f"{number} {word if number == 1 else plural}"
