"""Right-hand sides with the signature of generated code, compiled here, and a call with defaults."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from symbody.codegen.llvm.kernel_library import compile_kernels
from symbody.simulation.methods.explicit import Explicit, RawRun, integrate

_FILE: Final = Path(__file__).with_name("right_hand_side_kernels.py")


@dataclass(frozen=True, slots=True)
class Compiled:
    """A function in memory."""

    address: int


_ADDRESSES: Final = compile_kernels(_FILE.read_text(encoding="utf-8"), _FILE.name)
pendulum = Compiled(_ADDRESSES["pendulum"])
oscillator = Compiled(_ADDRESSES["oscillator"])
rational = Compiled(_ADDRESSES["rational"])
blow_up = Compiled(_ADDRESSES["blow_up"])
walled = Compiled(_ADDRESSES["walled"])
never_finite = Compiled(_ADDRESSES["never_finite"])
singular = Compiled(_ADDRESSES["singular"])
damped = Compiled(_ADDRESSES["damped"])
every_group = Compiled(_ADDRESSES["every_group"])
nothing = Compiled(_ADDRESSES["nothing"])


def run(
    function: Any, n_u: int, n_q: int, x0: Any, span: tuple[float, float], order: int = 8, **options: Any
) -> RawRun:
    """Integrate one of the above; the groups are empty unless given."""
    chosen = {"method": Explicit(order=order), "inputs": (), "parameters": (), "constants": (), **options}
    return integrate(function.address, 2, n_u, n_q, x0, span, **chosen)
