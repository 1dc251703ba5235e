"""`without_sampling`: the model with continuous signals and blocks in the place of sampled ones."""

from __future__ import annotations

from symbody.arguments import checked_arguments
from symbody.errors import ModelError, Problem
from symbody.model.element import Element
from symbody.model.model import Model
from symbody.model.signals.block import SignalBlock
from symbody.model.signals.signal import Signal


@checked_arguments
def without_sampling(model: Model) -> Model:
    """Return a model whose sampled signals and blocks are replaced by continuous ones, for analyses.

    A signal follows its formula at every time. A `PID` becomes the continuous one, its derivative filtered
    over a sample where it had no filter; a `TransferFunction` goes by the rule of Tustin; a `Delay` is
    approximated, a `RateLimit` lags by one sample. Held values that read themselves, `StateSpace` and
    `Hysteresis` have no continuous equivalent.

    Parameters
    ----------
    model : Model
        With sampled signals or blocks; one without them is returned as it is.

    Returns
    -------
    Model
        The continuous one.

    Raises
    ------
    ModelError
        Naming what has none, or an algebraic loop that sampling opened.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x")
    >>> held = sb.Signal("position", "x", sample=0.1)
    >>> sampled = sb.Model("cart", [rail, held])
    >>> len(sampled.held_signals), len(sb.without_sampling(sampled).held_signals)
    (1, 0)
    """
    problems: list[Problem] = []
    elements = [_continuous(element, problems) for element in model.elements]
    if problems:
        raise ModelError(*problems)
    return Model(
        model.name, elements, model.gravity, model.parameters, model.inputs, model.initial, model.ground,
        (), model.ground_shapes,
    )  # fmt: skip


def _continuous(element: Element, problems: list[Problem]) -> Element:
    if isinstance(element, Signal) and element.is_held:
        if element.value is None or element.name not in element.value.names:
            return Signal(element.name, element.value, output=element.output)
        problems.append(_no_equivalent(element, "its new value depends on the old one"))
    elif isinstance(element, SignalBlock) and element.signals[0].is_held:
        made = element.continuous
        if made is not None:
            return made
        problems.append(_no_equivalent(element, "no continuous block is equivalent to it"))
    return element


def _no_equivalent(element: Element, why: str) -> Problem:
    what = "it has no continuous equivalent"
    fix = "replace it in the model by a signal with a rate, or by its formula"
    return Problem("signal.no_continuous", f"{element.kind} {element.name}", what, why, fix)
