"""The one list of which equations are shown, under which heading, in which order.

Text, LaTeX, notebooks, reports, live pages and the editor print these sections, so that as many equations are
printed as there are unknowns.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final, NamedTuple

from symbody.equations.loads.friction import FrictionLaw
from symbody.equations.outputs.textbook import Textbook
from symbody.expr.canonical import ZERO, add, sub
from symbody.expr.graph import Graph, SymbolKind
from symbody.expr.opcodes import ADD, LEAVES, NEG, SUB, SYMBOL
from symbody.expr.printing.numerals import ALL_DIGITS, Numerals, written_numbers
from symbody.expr.rewrite import dependence, tree_sizes
from symbody.model.model import Model
from symbody.model.signals.signal import Signal

# Digits of computed numbers on screens and in reports.
SHOWN_DIGITS: Final = 6


class SectionTitle(NamedTuple):
    """What a section is called: in running text, and as a heading."""

    word: str
    heading: str


TITLES: Final[Mapping[str, SectionTitle]] = MappingProxyType(
    {
        "rates": SectionTitle("rates", "Rates of the coordinates"),
        "motion": SectionTitle("motion", "Equations of motion"),
        "positions": SectionTitle("constraints", "Constraints on positions"),
        "velocities": SectionTitle("velocity constraints", "Constraints on velocities"),
        "friction": SectionTitle("friction", "Dry friction"),
        "signals": SectionTitle("signals", "Signals"),
        "outputs": SectionTitle("outputs", "Signals of outputs"),
        "samples": SectionTitle("samples", "Sampled signals"),
    }
)
_IDENTICAL: Final = "holds identically"
_UNRESISTED: Final = "{} has no inertia, and no force acts on it"
_ONE_SIDED: Final = MappingProxyType(
    {
        1: "while the gap is closed; open, the left side is > 0",
        -1: "while it is taut; slack, the left side is < 0",
    }
)
_SLIPS: Final = "while it slips; at rest it holds up to this magnitude"
_NOTHING_MOVES: Final = "none: there are no speeds, because all motions are prescribed or nothing can move"


@dataclass(frozen=True, slots=True)
class EquationSection:
    """Equations ``left = right`` under a heading.

    Attributes
    ----------
    key : str
        Of `TITLES`.
    sides : tuple of (int, int)
        The nodes of both sides of each equation.
    leading : mapping of node to node
        The acceleration that comes first in the left side of each equation of motion.
    remarks : mapping of int to str
        What is said behind equations, by their place: why one reads ``0 = 0``, when one applies.
    words : tuple of (str, str)
        Names and what they stand for in words, where that is no formula.
    note : str
        What is said in place of equations where there are none.
    """

    key: str
    sides: tuple[tuple[int, int], ...] = ()
    leading: Mapping[int, int] = field(default_factory=dict)
    remarks: Mapping[int, str] = field(default_factory=dict)
    words: tuple[tuple[str, str], ...] = ()
    note: str = ""

    @property
    def title(self) -> SectionTitle:
        """What it is called."""
        return TITLES[self.key]

    @property
    def nodes(self) -> list[int]:
        """Both sides of each equation, one after the other."""
        return [node for pair in self.sides for node in pair]


def equation_sections(textbook: Textbook, limit: int) -> list[EquationSection]:
    """Return all equations that belong to the motion, without empty sections other than that of the motion.

    Parameters
    ----------
    limit : int
        Where all equations of motion have at most as many operations, they have what moves on the left.
    """
    return [section for section in _all_sections(textbook, limit) if section.sides or section.words
            or section.key == "motion"]  # fmt: skip


def _all_sections(textbook: Textbook, limit: int) -> list[EquationSection]:
    graph, model = textbook.formed.graph, textbook.formed.topology.model
    symbols = [graph.symbol(symbol.derivative) for symbol in textbook.formed.q]
    rates = zip(symbols, textbook.readable("qdot").nodes, strict=True)
    return [
        EquationSection("rates", tuple((left, right) for left, right in rates if left != right)),
        motion_section(textbook, limit),
        *constraint_sections(textbook),
        friction_section(textbook),
        EquationSection("signals", tuple(textbook.signal_equations)),
        EquationSection("outputs", words=tuple((s.name, str(s.output)) for s in model.signals if s.output)),
        EquationSection("samples", words=tuple(map(_sample_words, model.held_signals))),
    ]


def motion_section(textbook: Textbook, limit: int) -> EquationSection:
    """Return the equations of motion, one a speed."""
    formed = textbook.formed
    plain = list(
        zip(textbook.inertial_side.nodes, textbook.forcing_side(has_signals=True).nodes, strict=True)
    )
    sizes = tree_sizes(formed.graph, [node for pair in plain for node in pair])
    sides = equation_sides(textbook) if max(sizes, default=0) <= limit else plain
    accelerations = [formed.graph.symbol(symbol.derivative) for symbol in formed.u]
    names = [symbol.label for symbol in formed.u]
    return EquationSection(
        "motion", tuple(sides),
        {left: own for (left, _), own in zip(sides, accelerations, strict=True) if left != ZERO},
        {k: _UNRESISTED.format(names[k]) for k, pair in enumerate(sides) if pair == (ZERO, ZERO)},
        note="" if sides else _NOTHING_MOVES,
    )  # fmt: skip


def constraint_sections(textbook: Textbook) -> list[EquationSection]:
    """Return the constraints on positions, and those on velocities alone: one equation a multiplier."""
    positions = textbook.display("constraints").nodes
    velocities = textbook.display("velocity_constraints").nodes[len(positions) :]
    one_sided = {k: _ONE_SIDED[row.sense] for k, row in enumerate(textbook.formed.holonomic) if row.sense}
    return [_constraints("positions", positions, one_sided), _constraints("velocities", velocities, {})]


def friction_section(textbook: Textbook) -> EquationSection:
    """Return the laws of dry friction: one equation an effort, and one for each reaction that a law reads."""
    switching = {law.effort.index: law for law in textbook.formed.friction if law.switches}
    sides = tuple(textbook.friction_equations)
    remarks = {k: _at_rest(switching[left]) for k, (left, _) in enumerate(sides) if left in switching}
    return EquationSection("friction", sides, remarks=remarks)


def _at_rest(law: FrictionLaw) -> str:
    """Return when the law of a joint that sticks applies, and up to which effort it sticks."""
    friction = law.friction
    pairs = (friction.force, friction.static), (friction.mu, friction.mu_static)
    exchanged = [f", with {b.text} in place of {a.text}" for a, b in pairs if a is not None and b is not None]
    return f"{_SLIPS}{''.join(exchanged)}"


def _constraints(key: str, nodes: Sequence[int], one_sided: Mapping[int, str]) -> EquationSection:
    remarks = {**one_sided, **{k: _IDENTICAL for k, node in enumerate(nodes) if node == ZERO}}
    return EquationSection(key, tuple((node, ZERO) for node in nodes), remarks=remarks)


def _sample_words(signal: Signal) -> tuple[str, str]:
    """Return a signal that is sampled, what it is at each sample, and how often that is."""
    return signal.name, f"{signal.output or signal.value}, every {signal.sample} s"


def numerals_of(model: Model, digits: int | None) -> Numerals:
    """Return how numbers of a model's formulas are printed: those that it is written with in full."""
    if digits is None:
        return ALL_DIGITS
    sites = [site.formula.text for element in model.elements for site in element.formula_sites()]
    gravity = [component.text for component in model.gravity]
    return Numerals(digits, written_numbers([*sites, *gravity]))


def has_rounded(textbook: Textbook, nodes: Sequence[int], numerals: Numerals) -> bool:
    """Return whether numbers of formulas have more digits than are printed."""
    graph = textbook.formed.graph
    values = (graph.number(node) for node in graph.reachable(nodes) if graph.ops[node] in LEAVES - {SYMBOL})
    return any(
        value is not None and numerals.round_number(value if value >= 0 else -value) for value in values
    )


_MOVING = frozenset({SymbolKind.COORDINATE, SymbolKind.SPEED, SymbolKind.MULTIPLIER})


def equation_sides(textbook: Textbook) -> list[tuple[int, int]]:
    """Return the nodes of the left and the right side of each equation."""
    graph = textbook.formed.graph
    pairs = zip(textbook.inertial_side.nodes, textbook.forcing_side(has_signals=True).nodes, strict=True)
    return [_sides(graph, sub(graph, inertial, driving)) for inertial, driving in pairs]


def _sides(graph: Graph, total: int) -> tuple[int, int]:
    """Split ``total = 0`` into terms that move and terms that do not."""
    kinds = dependence(graph, [total])
    left, right = ZERO, ZERO
    for sign, term in signed_terms(graph, total):
        if kinds[term] & _MOVING:
            left = add(graph, left, term) if sign > 0 else sub(graph, left, term)
        else:
            right = sub(graph, right, term) if sign > 0 else add(graph, right, term)
    return left, right


def signed_terms(graph: Graph, node: int) -> list[tuple[int, int]]:
    """Return the signed terms of a sum, nested sums included."""
    terms = []
    stack = [(1, node)]
    while stack:
        sign, node = stack.pop()
        op = graph.ops[node]
        if op in (ADD, SUB):
            stack += [(sign if op == ADD else -sign, graph.right[node]), (sign, graph.left[node])]
        elif op == NEG:
            stack.append((-sign, graph.left[node]))
        else:
            terms.append((sign, node))
    return terms
