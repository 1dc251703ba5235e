"""Bristles: friction that deflects before it slips, as states of signals, so that nothing is an event.

The deflection w is a share of the one at which what rests breaks away. With the slip v, the flow p of what
slips, and g(v), the share that is left of the static coefficient,

    w' = v/deflection - p w,    p = alpha(|w|/g) max(0, v . w)/(|w| g deflection),

where alpha rises from 0 at `breakaway` to 1 as half a period of a sine (Dupont, Hayward, Armstrong and
Altpeter 2002). So nothing slips below `breakaway`, and what rests does not creep. Across two directions only
what stretches the deflection makes it slip: it is dragged along like a trailer. Without a threshold it is
``p = |v|/(g deflection)``, LuGre's law (Canudas de Wit, Olsson, Astrom and Lischinsky 1995).

The force is its limit at rest times ``-(w + T w'/sqrt(1 + (T v/deflection)^2))``: a spring and a damper,
which fades as the slip grows, as it must if it is to lose energy at all speeds (Olsson et al. 1998). That
both are proportional to the force along the normal is so of rough surfaces (Campana, Persson and Muser 2011).
"""

from __future__ import annotations

from functools import lru_cache
from typing import Final

from symbody.model.loads.friction import Friction
from symbody.model.signals.block import in_brackets
from symbody.model.signals.signal import Signal

# Without arguments: below this share nothing slips; what rests under its own weight then hardly swings.
_BREAKAWAY: Final = "0.7"
_DAMPING_TIME: Final = "2*sqrt({}/9.81)"
# A root of the slip's square has a slope where it is 0; a creep of 1e-15 m/s.
_STILL: Final = "1e-30"


@lru_cache(maxsize=1024)  # a model looks at its signals several times
def bristle_signals(
    friction: Friction, label: str, slips: tuple[tuple[str, str], ...], gap: str = ""
) -> tuple[Signal, ...]:
    """Return the states of bristles, with what their rates and their force are made of.

    Parameters
    ----------
    label : str
        With which all names begin.
    slips : tuple of (str, str)
        For each direction what ends the names along it, ``"_x"``, and the name of the slip.
    gap : str
        The name of what is negative while surfaces touch; without one they always do. When they part the
        bristles spring back in the time of their damper.
    """
    assert friction.deflection is not None
    length = in_brackets(friction.deflection)
    time = _DAMPING_TIME.format(length)
    if friction.damping_time is not None:
        time = in_brackets(friction.damping_time)
    states = {end: f"{label}{end}" for end, _ in slips}
    flow, limit, square = f"{label}_flow", "1", " + ".join(f"{slip}^2" for _, slip in slips)
    values = []
    if friction.stribeck is not None:
        limit = f"{label}_limit"
        values.append(Signal(limit, _limit(friction, square)))
    rate = _flow(friction, [*states.values()], [slip for _, slip in slips], limit, length)
    values.append(Signal(flow, f"if({gap} < 0, {rate}, 1/{time})" if gap else rate))
    rates = {end: f"{slip}/{length} - {flow}*{states[end]}" for end, slip in slips}
    fading = f"sqrt(1 + ({time}/{length})^2*({square}))"
    return (
        *(Signal(state, rate=rates[end]) for end, state in states.items()),
        *values,
        *(
            Signal(f"{label}_share{end}", f"{state} + {time}*({rates[end]})/{fading}")
            for end, state in states.items()
        ),
    )


def _limit(friction: Friction, square: str) -> str:
    """Return the share of the static coefficient that is left at a slip with this square."""
    resting, moving = friction.strongest, friction.mu if friction.force is None else friction.force
    assert friction.stribeck is not None
    high, low, scale = (in_brackets(each) for each in (resting, moving, friction.stribeck))
    return f"({low} + ({high} - {low})*exp(-({square})/{scale}^2))/{high}"


def _flow(friction: Friction, states: list[str], slips: list[str], limit: str, length: str) -> str:
    """Return by how much the deflection falls, as a share of it in a second."""
    given = friction.breakaway
    threshold = _BREAKAWAY if given is None else in_brackets(given)
    squares = [" + ".join(f"{name}^2" for name in names) for names in (states, slips)]
    slipping = f"sqrt({squares[1]} + {_STILL})/({limit}*{length})"
    if given is not None and given.constant() == 0:
        return slipping
    is_known = given is None or given.constant() is not None
    least = f"({threshold}*{limit})^2" if is_known else f"max(({threshold}*{limit})^2, {_STILL})"
    size = f"sqrt(max({squares[0]}, {least}))"
    begun = f"sin(pi/2*min(1, ({size}/{limit} - {threshold})/(1 - {threshold})))^2"
    stretch = " + ".join(f"{state}*{slip}" for state, slip in zip(states, slips, strict=True))
    # below the threshold not even a corner is left, so that linear equations hold to both sides
    law = f"{begun}*max(0, if({squares[0]} < {least}, -1, {stretch}))/({size}*{limit}*{length})"
    return law if is_known else f"if({threshold} > 0, {law}, {slipping})"
