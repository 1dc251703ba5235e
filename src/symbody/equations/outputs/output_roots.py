"""Outputs by name: the roots behind every word that compile, generate_code and results accept; and cures."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain
from types import MappingProxyType
from typing import Final

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.outputs.frame_motion import frame_motion_entries, frame_output
from symbody.equations.outputs.friction_outputs import (
    friction_effort,
    friction_normal,
    friction_rate,
    friction_reserve,
    gap,
    gap_acceleration,
    gap_acceleration_size,
    gap_rate,
    gap_restitution,
    gap_scale_output,
    mode_output,
    opening_effort,
    rigid_force,
    rigid_point,
    slip_along,
)
from symbody.equations.outputs.joint_outputs import effort_output, reaction_output, total_power
from symbody.equations.outputs.signal_outputs import signal_rates, substitute_signals
from symbody.equations.recursive.udot_derivatives import columns_of_slopes
from symbody.equations.solving.drift_correction import (
    position_move,
    position_residual,
    velocity_move,
    velocity_residual,
)
from symbody.equations.solving.mode_responses import mode_responses
from symbody.equations.solving.self_stress import substitute_shares
from symbody.equations.solving.slopes import acceleration_slopes, inverse_dynamics
from symbody.equations.solving.solution import resistance, solve, substitute_solution
from symbody.errors import ExpressionError, FormulationError, Problem, nearest
from symbody.expr.calculus import jacobian
from symbody.expr.expression import Expr
from symbody.expr.graph import Symbol, SymbolKind
from symbody.expr.language.formula import Formula
from symbody.expr.opcodes import SYMBOL
from symbody.expr.rewrite import symbols_of
from symbody.expr.sequences.sequence import Roots
from symbody.model.contacts.contact import Contact
from symbody.model.output_names import (
    DERIVATIVE_GROUPS,
    FRAME_OUTPUT,
    MOTION_WORDS,
    MULTIPLIER,
    OUTPUT_KINDS,
    DerivativeRequest,
    OutputName,
    kind_of,
    list_outputs,
    parse_derivative,
    read_output,
)

Output = tuple[tuple[int, ...], Sequence[Expr]]
# Takes equations and the words behind the first, of known names one for each argument of the kind.
Maker = Callable[[EquationsOfMotion, Sequence[str]], Output]

# What the loop of a motion evaluates: the work is one more state.
OF_STEPS: Final = ("xdot", "power")
# What decides which joints stick and which ropes pull; for the search for modes alone.
OF_MODES: Final = "mode_responses"
# What is summed up or measured along a motion, and known of its samples alone.
OF_MOTIONS: Final = ("work", "constraint_violation", "velocity_violation")


def output_roots(formed: EquationsOfMotion, name: str) -> Roots:
    """Return the roots of the output `name`.

    Whole names come first, then derivatives, names with arguments, then symbols and expressions in them;
    parentheses reach a symbol that bears the name of an output. In expressions, outputs stand in single
    quotes: ``sqrt('reaction A Fx'^2 + 'reaction A Fy'^2)``.
    Raises FormulationError, with the nearest names, if the name means nothing.
    """
    asked = parse_derivative(name)
    if asked is not None:
        return derivative_roots(formed, name, asked, evaluable_roots(formed, asked.output))
    shape, values = raw_output(formed, name)
    kind = kind_of(name)
    is_solved = kind is not None and not kind.arguments
    return _roots(name, shape, values if is_solved else _put_in_solution(formed, values))


def raw_output(formed: EquationsOfMotion, name: str) -> Output:
    """Return the shape and entries of an output, in u', multipliers and signals where it depends on these.

    A FormulationError with the nearest names if the name means nothing.
    """
    if parse_derivative(name) is not None:
        roots = output_roots(formed, name)
        return roots.shape, [Expr(formed.graph, node) for node in roots.nodes]
    asked = read_output(name, formed.topology.output_scope)
    if asked is not None:
        return _named_output(formed, asked, name)
    multiplier = _multiplier(formed, name)
    return _expression(formed, name) if multiplier is None else ((), [multiplier])


def _named_output(formed: EquationsOfMotion, asked: OutputName, name: str) -> Output:
    try:
        shape, values = MAKERS[asked.kind.word](formed, asked.words)
    except FormulationError as error:
        cure = quotation_cure(name, output_names(formed)) if asked.words else ""
        if not cure:
            raise
        raise FormulationError(*(replace(problem, fix=cure) for problem in error.problems)) from error
    return shape, substitute_shares(formed, values) if asked.words else values


def _multiplier(formed: EquationsOfMotion, name: str) -> Expr | None:
    """Return the multiplier of this name, None if there is none; names of constraints may have blanks."""
    if not name.startswith(MULTIPLIER):
        return None
    if any(name == row.name for row in formed.coupled.rows):
        return substitute_shares(formed, [formed.coupling_multipliers[name]])[0]
    if any(name == row.name for row in formed.redundant):
        raise FormulationError(_dropped_problem(formed, name))
    known = formed.readable_names
    return known.value(name) if name in known.values else None


def _expression(formed: EquationsOfMotion, name: str) -> Output:
    try:
        formula = Formula.from_value(name, has_outputs=True)
        value = formed.readable_names.expression(formula, outputs=quoted_output(formed, formula))
    except (ExpressionError, FormulationError) as error:
        fault = error.problems[0]
        is_quoted = fault.code == "equations.quoted_output"
        cure = fault.fix if is_quoted else _cure(formed, name)
        what = f"{name!r} is neither an output nor an expression"
        raise FormulationError(Problem("equations.unknown_output", name, what, fault.what, cure)) from error
    _check_is_measured(formed, name, value)
    return (), [value]


def _put_in_solution(formed: EquationsOfMotion, values: Sequence[Expr]) -> list[Expr]:
    """Return entries in t, q, u, s and r alone: signals, u' and multipliers replaced."""
    return substitute_solution(formed, substitute_signals(formed, values, raw_output))


def _dropped_problem(formed: EquationsOfMotion, name: str) -> Problem:
    kept = ", ".join(row.name for row in (*formed.coupled.rows, *formed.rows))
    cure = f"read those of the remaining constraints: {kept}" if kept else "leave it out"
    if formed.coupled.rows:
        cure += "; or form the equations without substitute=True, in which all of them share the load"
    return Problem("equations.dropped_multiplier", name, "its equation is redundant and was dropped",
                   "how they share the load is undetermined", cure)  # fmt: skip


def _cure(formed: EquationsOfMotion, name: str) -> str:
    """Return what to type instead of a text that is neither an output nor an expression."""
    if name in OF_MOTIONS:
        return f"read it from a computed motion: run[{name!r}], alone or in a formula"
    outputs = output_names(formed)
    frames = [frame for frame in formed.kinematics.velocities if "|" not in frame]
    known = [*outputs, *formed.names.symbols]
    is_capital = any(word != name and word.casefold() == name.casefold() for word in known)
    near = "" if is_capital else frame_cure(name, frames)
    near = near or nearest(name, known, "outputs and symbols")
    return quotation_cure(name, outputs) or near


def quoted_output(formed: EquationsOfMotion, formula: Formula, where: str = "") -> Callable[[str, int], int]:
    """Return what finds the node of an output that stands in quotes in a formula, by its name and column."""
    return partial(_quoted_output, formed, formula, where)


def _quoted_output(formed: EquationsOfMotion, formula: Formula, where: str, name: str, column: int) -> int:
    """Return the node of an output in quotes in a formula; an ExpressionError if it is none, or no number."""
    try:
        roots = output_roots(formed, name)
    except FormulationError as error:
        fault = error.problems[0]
        raise ExpressionError(
            formula.problem("equations.quoted_output", column, fault.what, fault.why, fault.fix, where)
        ) from error
    if roots.shape:
        what = f"{name!r} is not a number: its shape is {roots.shape}"
        fix = "name one component, such as 'reaction A Fx' or 'frame r P ground ground x'"
        raise ExpressionError(formula.problem("equations.quoted_output", column, what, "", fix, where))
    return roots.nodes[0]


def _check_is_measured(formed: EquationsOfMotion, name: str, value: Expr) -> None:
    """Refuse a coordinate that is neither a variable nor measured: a quaternion of a cut joint."""
    graph = formed.graph
    known = {symbol.name for symbol in (*formed.q, *formed.u)}
    symbols = (graph.symbols[graph.left[node]] for node in symbols_of(graph, [value.index]))
    unknown = [
        s.name for s in symbols if s.kind in (SymbolKind.COORDINATE, SymbolKind.SPEED) and s.name not in known
    ]
    if unknown:
        raise FormulationError(
            Problem("equations.not_measured", name, f"{', '.join(unknown)} cannot be measured",
                    "the joint is cut, and the sign and axes of a quaternion or its speeds are then "
                    "ambiguous",
                    "put the joint into the rotation tree, give it angles, or read frame R or w")
        )  # fmt: skip


def evaluable_roots(formed: EquationsOfMotion, name: str) -> Roots:
    """Return the roots of an output without unknown friction efforts, which formulas for reading keep."""
    roots = output_roots(formed, name)
    if not formed.friction or parse_derivative(name) is not None:
        return roots
    found = substitute_solution(formed, [Expr(formed.graph, node) for node in roots.nodes])
    return _roots(name, roots.shape, found)


def combined_roots(formed: EquationsOfMotion, name: str, outputs: Sequence[str]) -> Roots:
    """Return the entries of some outputs as the roots of one, solved for together."""
    values = [value for output in outputs for value in raw_output(formed, output)[1]]
    solved = _put_in_solution(formed, values)
    if formed.friction:
        solved = substitute_solution(formed, solved)
    return _roots(name, (len(solved),), solved)


def code_roots(formed: EquationsOfMotion, name: str) -> Roots:
    """Return the roots of an output to be compiled: derivatives of trees with many columns side by side."""
    asked = parse_derivative(name)
    if asked is None:
        return evaluable_roots(formed, name)
    return derivative_roots(formed, name, asked, evaluable_roots(formed, asked.output), side_by_side=True)


def output_names(formed: EquationsOfMotion) -> tuple[str, ...]:
    """Return the names of the outputs of these equations, other than motions of frames and multipliers."""
    scope = formed.topology.output_scope
    names = (
        each.text(scope) for each in list_outputs(scope) if each.kind.word not in (FRAME_OUTPUT, OF_MODES)
    )
    return (*names, *(row.name for row in formed.coupled.rows))


def _udot(formed: EquationsOfMotion) -> list[Expr]:
    return solve(formed)[0]


def _qdot(formed: EquationsOfMotion) -> list[Expr]:
    rates = formed.variables.rates
    return [Expr(formed.graph, rates[q.index]) for q in formed.expressions(formed.q)]


def _states(formed: EquationsOfMotion) -> tuple[Symbol, ...]:
    return (*formed.u, *formed.q, *formed.signal_states)


def _rates_of_states(formed: EquationsOfMotion) -> list[Expr]:
    return [*_udot(formed), *_qdot(formed), *_put_in_solution(formed, signal_rates(formed))]


def _slopes(formed: EquationsOfMotion, by: Sequence[Symbol]) -> list[list[Expr]]:
    """Return the derivatives of x' = (u', q', s') by symbols, all others held fixed."""
    return differentiate_output(formed, "xdot", [rate.index for rate in _rates_of_states(formed)], by)


def _roots(name: str, shape: tuple[int, ...], values: Sequence[Expr]) -> Roots:
    return Roots(name, shape, tuple(value.index for value in values))


def _measure(formed: EquationsOfMotion, words: Sequence[str], first: str) -> Output:
    name = " ".join((first, *filter(None, words)))
    value = formed.loads.measures.get(name)
    return _expression(formed, name) if value is None else ((), [value])


def _contact_force(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "contact_force C", or one component: of a rigid one by its rows and friction."""
    if f"contact_force {words[0]} z" in formed.loads.measures:
        return _measured_vector(formed, words, "contact_force", "xyz")
    if not _is_entry_of_contact(formed, words):
        return _expression(formed, " ".join(("contact_force", *filter(None, words))))
    return _entries(rigid_force(formed, words[0]), words)


def _contact_point(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "contact_point C", or one component: of a rigid one by its rows."""
    if f"contact_point {words[0]} z" in formed.loads.measures:
        return _measured_vector(formed, words, "contact_point", "xyz")
    if not _is_entry_of_contact(formed, words):
        return _expression(formed, " ".join(("contact_point", *filter(None, words))))
    return _entries(rigid_point(formed, words[0]), words)


def _is_entry_of_contact(formed: EquationsOfMotion, words: Sequence[str]) -> bool:
    """Return whether words are the name of a contact, with the letter of a component or without."""
    contacts = {each.name for each in formed.topology.model.elements if isinstance(each, Contact)}
    return words[0] in contacts and all(word in {"", *"xyz"} for word in words[1:])


def _entries(values: Sequence[Expr], words: Sequence[str]) -> Output:
    """Return all components of a vector, or the one that is named."""
    if any(words[1:]):
        return (), [values["xyz".index(words[1])]]
    return (len(values),), values


def _gap(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "gap C": of a contact what its law reads, of a stop its row."""
    name = f"gap {words[0]}"
    return _measure(formed, words, "gap") if name in formed.loads.measures else gap(formed, words)


def _measured_vector(formed: EquationsOfMotion, words: Sequence[str], first: str, letters: str) -> Output:
    """Return all entries of a measure, or the one that is named."""
    if any(words[1:]):
        return _measure(formed, words, first)
    values = [entry for letter in letters for entry in _measure(formed, (words[0], letter), first)[1]]
    return (len(values),), values


def _vector(compute: Callable[[EquationsOfMotion], Sequence[Expr]]) -> Maker:
    def make(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
        values = compute(formed)
        return (len(values),), values

    return make


def _scalar(compute: Callable[[EquationsOfMotion], Expr]) -> Maker:
    return lambda formed, words: ((), [compute(formed)])


def _matrix(
    compute: Callable[[EquationsOfMotion], Sequence[Sequence[Expr]]],
    columns: Callable[[EquationsOfMotion], Sequence[Symbol]] = lambda formed: formed.u,
) -> Maker:
    def make(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
        rows = compute(formed)
        return (len(rows), len(columns(formed))), [entry for row in rows for entry in row]

    return make


def _gravity_forcing(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "gravity_forcing [x]": what gravity does along all speeds, or one [N, N m]."""
    word = " ".join(words)
    if not word:
        values = _gravity_forces(formed, formed.u)
        return (len(values),), values
    found = [speed for speed in formed.u if speed.name == word]
    if not found:
        names = [speed.name for speed in formed.u]
        what = f"{word!r} is no coordinate whose rate is a speed of these equations"
        raise FormulationError(
            Problem("equations.unknown_speed", f"gravity_forcing {word}", what, "", nearest(word, names))
        )
    return (), _gravity_forces(formed, found)


def _gravity_forces(formed: EquationsOfMotion, along: Sequence[Symbol]) -> list[Expr]:
    """Return the power of all weights by each of some speeds [N, N m]."""
    graph, model = formed.graph, formed.topology.model
    gravity = formed.names.triple(model.gravity, "gravity")
    forces = [Expr(graph, 0)] * len(along)
    speeds = [graph.symbol(symbol) for symbol in along]
    for body in model.bodies:
        velocity = frame_motion_entries(formed, "v", body.name)[1]
        mass = formed.names.expression(body.mass, f"body {body.name}, mass")
        rows = jacobian(graph, [entry.index for entry in velocity], speeds)
        for pull, row in zip(gravity, rows, strict=True):
            forces = [
                force + mass * pull * Expr(graph, slope) for force, slope in zip(forces, row, strict=True)
            ]
    return forces


def _for_all_kinds(makers: dict[str, Maker]) -> Mapping[str, Maker]:
    """Return the functions, one for each kind of the registry."""
    odd = makers.keys() ^ OUTPUT_KINDS.keys()
    if odd:
        raise LookupError(f"a function without a kind of output, or a kind without a function: {sorted(odd)}")
    return MappingProxyType(makers)


# One function for each kind of output. Those about constraints are empty for a tree without any, but they
# exist, with their shapes.
MAKERS: Final = _for_all_kinds(
    {
        "kinetic_energy": _scalar(lambda formed: formed.kinetic_energy),
        "potential_energy": _scalar(lambda formed: formed.potential_energy),
        "energy": _scalar(lambda formed: formed.kinetic_energy + formed.potential_energy),
        "power": _scalar(lambda formed: substitute_solution(formed, [total_power(formed)])[0]),
        "length": partial(_measure, first="length"),
        "angle": partial(_measure, first="angle"),
        "effort": effort_output,
        "friction": friction_effort,
        "friction_normal": friction_normal,
        "friction_reserve": friction_reserve,
        "friction_rate": friction_rate,
        "slip_along": slip_along,
        "mode": mode_output,
        "reaction": reaction_output,
        "rope_tension": opening_effort,
        "rope_length": gap_scale_output,
        "rope_slack": gap,
        "rope_slack_dot": gap_rate,
        "rope_slack_ddot": gap_acceleration,
        "rope_size": gap_acceleration_size,
        "gap": _gap,
        "contact_force": _contact_force,
        "contact_point": _contact_point,
        "slip": partial(_measured_vector, first="slip", letters="xy"),
        "opening_effort": opening_effort,
        "gap_dot": gap_rate,
        "gap_ddot": gap_acceleration,
        "row_gap": gap,
        "gap_scale": gap_scale_output,
        "restitution": gap_restitution,
        FRAME_OUTPUT: frame_output,
        "udot": _vector(_udot),
        "qdot": _vector(_qdot),
        "xdot": _vector(_rates_of_states),
        "signal_rates": _vector(lambda formed: _put_in_solution(formed, signal_rates(formed))),
        "A": _matrix(lambda formed: _slopes(formed, _states(formed)), lambda formed: _states(formed)),
        "B": _matrix(lambda formed: _slopes(formed, formed.inputs), lambda formed: formed.inputs),
        "lambda": _vector(lambda formed: solve(formed)[1]),
        "mass_matrix": _matrix(lambda formed: formed.dynamics.mass_matrix),
        "forcing": _vector(lambda formed: formed.dynamics.forcing),
        "gravity_forcing": _gravity_forcing,
        "bias": _vector(lambda formed: [-force for force in formed.dynamics.forcing]),
        "inverse_dynamics": _vector(inverse_dynamics),
        "constraints": _vector(lambda formed: [row.value for row in formed.holonomic]),
        "velocity_constraints": _vector(velocity_residual),
        "gamma": _vector(lambda formed: [row.gamma for row in formed.rows]),
        "jacobian": _matrix(lambda formed: formed.jacobian),
        "position_jacobian": _matrix(lambda formed: formed.position_jacobian, lambda formed: formed.q),
        "position_residual": _vector(position_residual),
        "position_move": _vector(position_move),
        "velocity_residual": _vector(velocity_residual),
        "velocity_move": _vector(velocity_move),
        "friction_residual": _vector(lambda formed: resistance(formed).residuals),
        "friction_margin": _vector(lambda formed: resistance(formed).margins),
        OF_MODES: _vector(mode_responses),
        "alignment": _vector(lambda formed: list(formed.alignments)),
    }
)


def derivative_roots(
    formed: EquationsOfMotion,
    name: str,
    asked: DerivativeRequest,
    values: Roots,
    *,
    side_by_side: bool = False,
) -> Roots:
    """Return the derivatives of `values`, the roots of the output; the last axis counts the symbols.

    All other symbols are held fixed; components of a quaternion count as independent.
    Raises FormulationError if a word is none of ``q``, ``u``, ``r``, ``s`` and no symbol of the equations.

    Parameters
    ----------
    side_by_side : bool
        Whether programs for several columns may be among the nodes: faster as code, but for nothing else.
    """
    by = tuple(chain.from_iterable(_symbols(formed, name, word) for word in asked.by))
    rows = differentiate_output(formed, asked.output, values.nodes, by, side_by_side=side_by_side)
    shape = values.shape if asked.alone else (*values.shape, len(by))
    given = values.nodes if side_by_side else ()
    return Roots(name, shape, tuple(entry.index for row in rows for entry in row), given)


def differentiate_output(
    formed: EquationsOfMotion,
    output: str,
    nodes: Sequence[int],
    by: Sequence[Symbol],
    *,
    side_by_side: bool = False,
) -> list[list[Expr]]:
    """Return the derivatives of an output, one row an entry; those of u' by way of the inverse dynamics."""
    graph = formed.graph
    places = [graph.symbol(symbol) for symbol in by]
    if output == "inverse_dynamics":
        columns = columns_of_slopes(graph, nodes, places)
        return [[Expr(graph, column[k]) for column in columns] for k in range(len(nodes))]
    first = len(formed.u) if output in ("udot", "xdot") else 0
    slopes = acceleration_slopes(formed, by, side_by_side=side_by_side) if first else []
    rest = jacobian(graph, nodes[first:], places)
    return [*slopes, *([Expr(graph, entry) for entry in row] for row in rest)]


def _symbols(formed: EquationsOfMotion, name: str, word: str) -> tuple[Symbol, ...]:
    """Return the symbols of a group or of one name; parentheses reach a symbol named like a group."""
    groups = {"q": formed.q, "u": formed.u, "r": formed.inputs, "s": formed.signal_states}
    if word in groups:
        return groups[word]
    graph, inner = formed.graph, word.strip("() ")
    node = formed.names.node(inner)
    if node is not None and graph.ops[node] == SYMBOL:
        return (graph.symbols[graph.left[node]],)
    known = [*DERIVATIVE_GROUPS, *formed.names.symbols]
    what = f"cannot differentiate by {word!r}"
    why = "it is not a symbol of these equations, or is replaced by an expression"
    raise FormulationError(Problem("equations.derivative_by", name, what, why, nearest(inner, known)))


_KINDS: Final = MappingProxyType({word: kind for kind, words in MOTION_WORDS.items() for word in words})
_FRAME: Final = rf"{FRAME_OUTPUT} (?:{'|'.join(MOTION_WORDS)})(?: [^\W\d][\w.]*){{1,4}}"


def frame_cure(name: str, frames: Collection[str]) -> str:
    """Return the output of a frame's motion that was probably meant, or ``""``.

    Parameters
    ----------
    frames : collection of str
        Bodies and frames as outputs name them: ``"Arm"``, ``"Arm.tip"``.

    >>> frame_cure("position tip", ["ground", "Arm", "Arm.tip"])
    "did you mean 'frame r Arm.tip'?"
    """
    if place := _full_name(name, frames):
        return f"did you mean 'frame r {place}'?"
    words = name.split()
    for count in (2, 1):
        kind, rest = _KINDS.get(" ".join(words[:count])), " ".join(words[count:])
        if kind is None or not rest:
            continue
        place = _full_name(rest, frames)
        if place:
            return f"did you mean 'frame {kind} {place}'?"
        return f"write 'frame {kind} END' with a body or frame for END: {nearest(rest, frames)}"
    return ""


def _full_name(name: str, frames: Collection[str]) -> str:
    """Return the frame of this name, with its body in front; empty if there is none or more than one."""
    if name in frames:
        return name
    ending = [frame for frame in frames if frame.endswith(f".{name}")]
    return ending[0] if len(ending) == 1 else ""


def quotation_cure(text: str, outputs: Iterable[str]) -> str:
    """Return what to type where outputs inside a formula lack their quotes; empty where none do.

    >>> quotation_cure("2*reaction A Fx", ["reaction A", "reaction A Fx"])
    "inside a formula, write outputs in single quotes: 2*'reaction A Fx'"
    >>> quotation_cure("[reaction A Fx]^2", ["reaction A", "reaction A Fx"])
    "inside a formula, write outputs in single quotes: 'reaction A Fx'^2"
    """
    if re.search(r"[-+*/^(<>,]", text) is None:
        return ""
    names = sorted((name for name in outputs if " " in name), key=len, reverse=True)
    words = "|".join([*map(re.escape, names), _FRAME])
    bare = rf"(?<![\w'])(?:\"({words})\"|\[({words})\]|({words}))(?![\w'])"
    quoted = re.sub(bare, lambda found: f"'{found[1] or found[2] or found[3]}'", text)
    return "" if quoted == text else f"inside a formula, write outputs in single quotes: {quoted}"
