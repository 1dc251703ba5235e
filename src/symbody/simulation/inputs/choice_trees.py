"""Tables in formulas: trees of choices between constants by one value, which are read by halving.

A table of n points is n comparisons and n choices. Evaluated one by one at n times they take n^2 operations
and as much memory; as one step function they take n log n.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.expr import opcodes as op
from symbody.expr.sequences.sequence import Operation

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

# The code of a step function among operations: no operation of the graph.
STEPS: Final = -1
# Fewer choices than this stay as they are.
_FEWEST: Final = 16


@dataclass(frozen=True, slots=True, eq=False)
class StepFunction:
    """A function that is constant between bounds.

    Attributes
    ----------
    argument : int
        The value it is a function of.
    bounds : (n,) array
        Ascending; from each on the next value holds.
    values : (n + 1,) array
    """

    argument: int
    bounds: Floats
    values: Floats

    def evaluate(self, x: Floats) -> Floats:
        """Return the values at x; at NaN the last, as comparisons choose."""
        found: Floats = self.values[np.searchsorted(self.bounds, x, side="right")]
        return found


def fold_choices(
    operations: Sequence[Operation], numbers: Floats, is_affine: Flags
) -> tuple[list[Operation], tuple[StepFunction, ...]]:
    """Return operations with step functions in the place of trees of choices, and these functions.

    Parameters
    ----------
    numbers : (n,) array
        The values of constants.
    is_affine : (n,) array of bool
        Values that are affine in time; only choices by these are known before a motion.
    """
    constants: dict[int, float] = {}
    trees: dict[int, StepFunction] = {}
    for k, (code, operands, _) in enumerate(operations):
        if code in op.LEAVES and code != op.SYMBOL:
            constants[k] = float(numbers[k])
        elif code == op.NEG and operands[0] in constants:
            constants[k] = -constants[operands[0]]
        elif code == op.SELECT and operations[operands[0]].op == op.LT:
            argument, bound = operations[operands[0]].operands
            branches = [_branch(constants, trees, place, argument) for place in operands[1:]]
            if is_affine[argument] and bound in constants and None not in branches:
                left, right = (branch for branch in branches if branch is not None)
                trees[k] = _join(left, constants[bound], right)
    large = {k: tree for k, tree in trees.items() if tree.bounds.size >= _FEWEST}
    folded = list(operations)
    for number, (k, tree) in enumerate(large.items()):
        folded[k] = Operation(STEPS, (tree.argument,), number)
    return folded, tuple(large.values())


def _branch(
    constants: Mapping[int, float], trees: Mapping[int, StepFunction], place: int, argument: int
) -> StepFunction | None:
    """Return a branch of a choice by an argument, if it is a constant or a choice by the same."""
    if place in constants:
        return StepFunction(argument, np.zeros(0), np.array([constants[place]]))
    tree = trees.get(place)
    return tree if tree is not None and tree.argument == argument else None


def _join(left: StepFunction, bound: float, right: StepFunction) -> StepFunction:
    """Return what is the left function below a bound, and the right one from it on."""
    below = int(np.searchsorted(left.bounds, bound, side="left"))
    above = int(np.searchsorted(right.bounds, bound, side="right"))
    return StepFunction(
        left.argument,
        np.concatenate([left.bounds[:below], [bound], right.bounds[above:]]),
        np.concatenate([left.values[: below + 1], right.values[above:]]),
    )
