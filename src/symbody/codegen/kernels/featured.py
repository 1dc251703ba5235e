"""Kernels made for what a motion has: conditions on features are decided, what is not called is dropped."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

from symbody.codegen.kernels.tree import (
    Apply,
    Call,
    Choose,
    Count,
    Expression,
    KernelTree,
    Literal,
    Repeat,
    Statement,
    Variable,
    assigned_names,
    called_kernels,
    effects_of,
    variable_names,
    walk,
)


def with_features(
    kernels: Mapping[str, KernelTree], roots: Sequence[str], features: Collection[str]
) -> Mapping[str, KernelTree]:
    """Return what some kernels need of all, each behind those that it calls.

    Parameters
    ----------
    features : collection of str
        Those that are 1; all others are 0.
    """
    made: dict[str, KernelTree] = {}
    waiting = list(roots)
    while waiting:
        name = waiting.pop()
        if name not in made:
            tree = kernels[name]
            body = tuple(_fold(tree.body, features))
            kept = assigned_names(body)
            variables = {local: kind for local, kind in tree.variables.items() if local in kept}
            made[name] = replace(tree, body=body, variables=variables)
            waiting.extend(called_kernels(effects_of(body)))
    return {name: made[name] for name in kernels if name in made}


def without_unused(kernels: Mapping[str, KernelTree]) -> dict[str, KernelTree]:
    """Return kernels without the parameters that they do not use."""
    made: dict[str, KernelTree] = {}
    for name, tree in kernels.items():
        body = _without_arguments(tree.body, kernels, made)
        used = variable_names(body) | {
            node.kernel for node in walk(body) if isinstance(node, Call) and node.is_parameter
        }
        kept = tuple(p for p in tree.parameters if p.name in used)
        made[name] = replace(tree, body=body, parameters=kept)
    return made


def _without_arguments(node: Any, kernels: Mapping[str, KernelTree], made: Mapping[str, KernelTree]) -> Any:
    """Return a node without arguments for parameters that are dropped."""
    if isinstance(node, tuple):
        return tuple(_without_arguments(each, kernels, made) for each in node)
    if not is_dataclass(node) or isinstance(node, type | Literal | Variable):
        return node
    if isinstance(node, Call) and not node.is_parameter:
        kept = {p.name for p in made[node.kernel].parameters}
        pairs = zip(node.arguments, kernels[node.kernel].parameters, strict=True)
        node = replace(node, arguments=tuple(argument for argument, p in pairs if p.name in kept))
    changes = {field.name: getattr(node, field.name) for field in fields(node)}
    return replace(node, **{name: _without_arguments(each, kernels, made) for name, each in changes.items()})


def _fold(body: Sequence[Statement], features: Collection[str]) -> Iterator[Statement]:
    """Yield statements without those that do not follow from the features."""
    for statement in body:
        if isinstance(statement, Count | Repeat):
            yield replace(statement, body=tuple(_fold(statement.body, features)))
        elif not isinstance(statement, Choose):
            yield statement
        else:
            condition = _decide(statement.condition, features)
            if isinstance(condition, bool):
                yield from _fold(statement.body if condition else statement.otherwise, features)
            else:
                ways = (tuple(_fold(way, features)) for way in (statement.body, statement.otherwise))
                yield Choose(condition, *ways)


def _decide(condition: Expression, features: Collection[str]) -> Expression | bool:
    """Return a condition, or whether it is true if features decide that."""
    match condition:
        case Apply("!=", (Variable(name), Literal(value=0))) if name.isupper():
            return name in features
        case Apply("and" | "or" as operator, operands):
            decided = [_decide(operand, features) for operand in operands]
            ends = operator == "or"
            if any(each is ends for each in decided):
                return ends
            left = [each for each in decided if not isinstance(each, bool)]
            if len(left) < len(operands):
                return left[0] if left else not ends
    return condition
