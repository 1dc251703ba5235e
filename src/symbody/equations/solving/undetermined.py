"""Which components of reactions follow from the motion, and which share in no determined way.

With the components ``r + B nu``, ``J^T nu = 0`` of `self_stress`, a component is undetermined where its row
of B does not vanish on the null space of J^T. Part of that is seen on the graph: constraints that hold
identically have columns of zeros in J^T. The rest is counted at configurations.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import groupby
from random import Random
from typing import Final, NamedTuple

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.loads.friction import FrictionLaw
from symbody.equations.solving.negligible_constraints import input_places, random_point
from symbody.equations.solving.self_stress import Component, SelfStress, StressBlock, self_stress
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Roots, build_sequence
from symbody.manifold import null_space
from symbody.tolerances import RANK

_FORCES: Final = ("Fx", "Fy", "Fz")
_MOMENTS: Final = ("Mx", "My", "Mz")


class Undetermined(NamedTuple):
    """What one configuration leaves open.

    Attributes
    ----------
    redundant : int
        Constraints that follow from the others.
    names : frozenset of str
        Outputs that do not follow from the motion: "reaction J Fx", "effort J".
    """

    redundant: int
    names: frozenset[str]


def find_identically_undetermined(formed: EquationsOfMotion) -> tuple[str, ...]:
    """Return the outputs that share constraints which hold identically in the coordinates of a mechanism."""
    stress = self_stress(formed)
    return stress.always.get(None, partial(_always, formed, stress))


def _always(formed: EquationsOfMotion, stress: SelfStress) -> tuple[str, ...]:
    blocks = []
    for block in stress.blocks:
        idle = [k for k in range(len(block.rows)) if all(row[k].is_zero for row in block.slopes)]
        if idle:
            parts = [{place: tuple(row[k] for k in idle) for place, row in rows.items()}
                     for rows in (block.changes, block.weighted)]  # fmt: skip
            blocks.append(StressBlock(tuple(block.rows[k] for k in idle), (), *parts))
    if not blocks:
        return ()
    (found,) = _find_in_blocks(formed, blocks, [random_point(formed, {}, Random(7))], RANK)
    return in_order(formed, found.names)


def find_undetermined(
    formed: EquationsOfMotion, points: Iterable[Mapping[str, Sequence[float]]], cut: float = RANK
) -> list[Undetermined]:
    """Return the outputs that each of some configurations leaves undetermined.

    Parameters
    ----------
    points : iterable of mapping
        Values of q, parameters p, inputs r and t, on which the loops close.
    cut : float
        Of the length of a row of J^T: what is left of it beyond others counts as rounding below.
    """
    return _find_in_blocks(formed, self_stress(formed).blocks, points, cut)


def _find_in_blocks(
    formed: EquationsOfMotion,
    blocks: Sequence[StressBlock],
    points: Iterable[Mapping[str, Sequence[float]]],
    cut: float,
) -> list[Undetermined]:
    roots = []
    for k, block in enumerate(blocks):
        for word, rows in (("slopes", block.slopes), ("changes", block.changes.values()),
                           ("weighted", block.weighted.values())):  # fmt: skip
            nodes = tuple(entry.index for row in rows for entry in row)
            roots.append(Roots(f"{word} {k}", (len(nodes),), nodes))
    program = build_sequence(formed.graph, roots, input_places(formed))
    components, found = self_stress(formed).components, []
    for point in points:
        values = [[float(x) for x in group] for group in evaluate_sequence(program, point)]
        found.append(_find_at_point(components, blocks, values, cut))
    return found


def generic(found: Sequence[Undetermined]) -> Undetermined:
    """Return the outputs that the configurations leave undetermined, singular ones aside."""
    least = min(one.redundant for one in found)
    return Undetermined(least, frozenset().union(*(one.names for one in found if one.redundant == least)))


def in_order(formed: EquationsOfMotion, names: Collection[str]) -> tuple[str, ...]:
    """Return outputs in the order of the joints, without those that have no name."""
    listed = dict.fromkeys(component.name for component in self_stress(formed).components)
    outputs = (name for name in listed if not name.startswith("lambda_"))
    return tuple(name for name in outputs if name in names)


def share_notes(formed: EquationsOfMotion, names: Sequence[str], where: str = "") -> tuple[str, ...]:
    """Return what is said of outputs that do not follow from the motion, and of friction that reads them."""
    if not names:
        return ()
    notes = [
        f"redundant constraints leave undetermined{where}: {_list_outputs(names)}; their values are those "
        f"of the minimum-norm solution"
    ]
    forces = {f"reaction {law.owner} {entry}" for law in formed.friction for entry in _entries_read(law)}
    rubbing = dict.fromkeys(name.rpartition(" ")[0].partition(" ")[2] for name in names if name in forces)
    if rubbing:
        notes.append(
            f"friction of {', '.join(rubbing)} depends on undetermined reactions: it is computed from their "
            f"minimum-norm solution"
        )
    return tuple(notes)


def _entries_read(law: FrictionLaw) -> tuple[str, ...]:
    """Return the entries of a joint's reaction that its friction may follow from: none along its axis."""
    if law.joint is None or not law.reads_reaction:
        return ()
    slides, axis = law.joint.translation_coordinates, getattr(law.joint, "axis", "")
    turns_alone = not slides or not law.joint.rotation_coordinates
    forces = tuple(entry for entry in _FORCES if not (turns_alone and entry == f"F{axis}"))
    return (*forces, *_MOMENTS) if slides and law.radius is not None else forces


def _list_outputs(names: Sequence[str]) -> str:
    """Return outputs as text: the entries of one reaction together."""
    pairs = [name.rpartition(" ") if name.startswith("reaction ") else (name, "", "") for name in names]
    groups = groupby(pairs, key=lambda pair: pair[0])
    return "; ".join(f"{owner} {', '.join(entry for *_, entry in group)}".rstrip() for owner, group in groups)


def _find_at_point(
    components: Sequence[Component],
    blocks: Sequence[StressBlock],
    values: Sequence[Sequence[float]],
    cut: float,
) -> Undetermined:
    count, names = 0, set()
    for k, block in enumerate(blocks):
        n = len(block.rows)
        slopes, changes, weighted = (list(_rows(group, n)) for group in values[3 * k : 3 * k + 3])
        pairs = list(zip(changes, weighted, strict=True))
        sizes = [math.sqrt(sum(b[i] * w[i] for b, w in pairs)) or 1.0 for i in range(n)]
        scaled = ([x / size for x, size in zip(row, sizes, strict=True)] for row in slopes)
        free = null_space([unit for row in scaled if (unit := _unit(row))] or [[0.0] * n], cut)
        count += free.shape[1]
        for place, (row, other) in zip(block.changes, pairs, strict=True):
            share = [math.sqrt(x * y) / size for x, y, size in zip(row, other, sizes, strict=True)]
            signed = [math.copysign(x, y) for x, y in zip(share, row, strict=True)]
            if math.hypot(*(signed @ free)) > RANK:
                names.add(components[place].name)
    return Undetermined(count, frozenset(names))


def _rows(values: Sequence[float], n: int) -> Iterator[list[float]]:
    return (list(values[k : k + n]) for k in range(0, len(values), n))


def _unit(row: Sequence[float]) -> list[float]:
    """Return a row of length 1; nothing of one of zeros."""
    length = math.hypot(*row)
    return [x / length for x in row] if length > 0.0 else []
