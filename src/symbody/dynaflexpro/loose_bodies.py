"""Free joints for bodies that no joint holds, with six coordinates as DynaFlexPro gives them."""

from __future__ import annotations

from symbody.model.joints import Free
from symbody.model.model import Model
from symbody.model.naming import GROUND


def with_free_joints(model: Model) -> tuple[Model, tuple[str, ...]]:
    """Return a model in which every body has a joint, and what was added.

    The coordinates of a body B are ``B_x, B_y, B_z`` and the Cardan angles ``B_alpha, B_beta, B_gamma``
    about x, y, z.
    """
    loose = _loose(model)
    if not loose:
        return model, ()
    joints = [_free(body) for body in loose]
    complete = Model(
        model.name,
        [*model.elements, *joints],
        gravity=model.gravity,
        parameters=model.parameters,
        inputs=model.inputs,
        initial=model.initial,
        ground=model.ground,
        ground_shapes=model.ground_shapes,
    )
    return complete, tuple(f"body {body} is free: six coordinates, Cardan angles x-y-z" for body in loose)


def _loose(model: Model) -> list[str]:
    """Return the bodies without a joint; the model itself refuses bodies joined to each other alone."""
    held = {end.body for joint in model.joints for end in (joint.start, joint.end)}
    return [body.name for body in model.bodies if body.name not in held]


def _free(body: str) -> Free:
    names = [f"{body}_{word}" for word in ("x", "y", "z", "alpha", "beta", "gamma")]
    return Free(f"{body}_free", GROUND, body, angles="123", coordinates=names)
