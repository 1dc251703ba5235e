"""Four states at once, in a register, for functions that numba compiles; see `vectors`.

The cache of the compiled loop does not see a change of this file: renew `loop.SOURCES` after one.
"""

from __future__ import annotations

from typing import Final

from symbody.simulation.native.vectors import Vectors

WIDTH: Final = 4
_STATES: Final = Vectors("States", WIDTH)

four: Final = _STATES.take
put: Final = _STATES.put
everywhere: Final = _STATES.spread
plus: Final = _STATES.operation(lambda builder, a, b: builder.fadd(a, b))
times: Final = _STATES.operation(lambda builder, a, b: builder.fmul(a, b))
