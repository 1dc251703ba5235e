"""Which numbers shapes can have."""

from __future__ import annotations

from collections.abc import Sequence

from symbody.model.checks.physics import check_frame
from symbody.model.numeric_checks import NumericChecks
from symbody.model.shapes.shape import BodyShape


def check_shapes(check: NumericChecks, shapes: Sequence[BodyShape], where: str) -> None:
    """Refuse negative sizes, opacities beyond 0 to 1, and rotations that are none."""
    for k, shape in enumerate(shapes):
        place = f"{where}[{k}]"
        check_frame(check, shape.frame, place)
        for path, formula in shape.lengths:
            length = check.value(formula, f"{place}.{path}")
            if length is not None and length < 0:
                check.refuse(
                    "model.negative_size", f"{place}.{path}", f"the length is {length:g} m",
                    "a sign is wrong", "give a positive length",
                )  # fmt: skip
        opacity = check.value(shape.opacity, f"{place}.opacity")
        if opacity is not None and not 0 <= opacity <= 1:
            check.refuse(
                "model.opacity", f"{place}.opacity", f"the opacity is {opacity:g}",
                "0 is invisible, 1 hides all behind it", "give a number from 0 to 1",
            )  # fmt: skip
