"""`Friction`: dry friction along the one free direction of a joint."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import final

from symbody.expr.language.formula import Formula
from symbody.model.checker import Checker
from symbody.model.door import Door, Value
from symbody.model.uses import Scope, Use

# Constants of the joint; the others may change with the motion.
_CONSTANT = ("radius", "v0")


@final
@dataclass(frozen=True, slots=True, init=False)
class Friction:
    """Dry friction in a joint, from its own reaction or of given strength.

    A prismatic joint is held back by ``mu*N``, a revolute joint by ``mu*radius*N``, where N is the magnitude
    of the reaction across the axis; or both by `force`. With `v0` the law is smooth, proportional to
    ``sin(atan(v/v0))``; without it the joint sticks and slips by events.

    Parameters
    ----------
    mu : number or formula
        Coefficient of friction while it slides.
    mu_static : number or formula, optional
        Coefficient up to which it sticks; by default mu. Without meaning where there is `v0`.
    radius : number or formula, optional
        Of the bearing [m]: a revolute joint needs it. In a prismatic joint the moment it transmits, over
        `radius`, counts as one more component of its reaction; without it forces alone count.
    v0 : number or formula, optional
        Speed at which a smooth law has 0.71 of its strength [m/s, rad/s].
    force : number or formula, optional
        Strength whatever the reaction [N, N m of a revolute joint]; instead of mu.
    static : number or formula, optional
        Strength up to which it sticks; by default `force`.

    Raises
    ------
    ModelError
        If an entry is not a formula, or entries contradict each other.
    """

    mu: Formula
    mu_static: Formula | None
    radius: Formula | None
    v0: Formula | None
    force: Formula | None
    static: Formula | None

    def __init__(
        self,
        mu: Value = 0,
        mu_static: Value | None = None,
        radius: Value | None = None,
        v0: Value | None = None,
        force: Value | None = None,
        static: Value | None = None,
    ) -> None:
        door = Door("friction")
        object.__setattr__(self, "mu", door.formula(mu, "mu"))
        optional = (
            ("mu_static", mu_static),
            ("radius", radius),
            ("v0", v0),
            ("force", force),
            ("static", static),
        )
        for name, value in optional:
            object.__setattr__(self, name, None if value is None else door.formula(value, name))
        _check_laws(self, door)
        door.close()

    @property
    def reads_reaction(self) -> bool:
        """Whether the joint's reaction decides its strength."""
        return self.force is None

    @property
    def is_smooth(self) -> bool:
        """Whether it is a function of the velocity, without sticking."""
        return self.v0 is not None

    @property
    def is_none(self) -> bool:
        """Whether there is no friction at all."""
        return self.force is None and self.mu.constant() == 0 and self.mu_static is None

    def uses(self, path: str) -> Iterator[Use]:
        """Return where the formulas stand, below `path`."""
        for field in fields(self):
            formula = getattr(self, field.name)
            if formula is not None:
                scope = Scope.CONSTANT if field.name in _CONSTANT else Scope.LOAD
                yield Use(f"{path}.{field.name}", formula, scope)


def friction_from(door: Door, value: object, path: str) -> Friction | None:
    """Return friction, or None where there is none."""
    if value is None or isinstance(value, Friction):
        return value
    door.refuse(
        "model.not_friction",
        path,
        f"{value!r} is not friction",
        "",
        "write Friction(mu=.., v0=..), or Friction(force=.., v0=..)",
    )
    return None


def check_friction(check: Checker, friction: Friction, where: str, turns: bool) -> None:
    """Refuse friction with impossible numbers; `turns` says that it holds back an angle."""
    for word, name in (("coefficient", "mu"), ("coefficient", "mu_static"), ("strength", "force"),
                       ("strength", "static")):  # fmt: skip
        value = _value(check, friction, name, where)
        if value is not None and value < 0:
            check.refuse(
                "model.negative_friction", f"{where}.{name}", f"the {word} {name} is {value:g}",
                "friction always opposes the motion", "give a number that is not negative",
            )  # fmt: skip
    for name in _CONSTANT:
        value = _value(check, friction, name, where)
        if value is not None and value <= 0:
            check.refuse(
                "model.friction_scale", f"{where}.{name}", f"{name} is {value:g}",
                "it is a scale or a lever",
                f"give a positive number, or leave {name} out",
            )  # fmt: skip
    for moving, resting in (("mu", "mu_static"), ("force", "static")):
        low, high = _value(check, friction, moving, where), _value(check, friction, resting, where)
        if low is not None and high is not None and high < low:
            check.refuse(
                "model.static_friction", f"{where}.{resting}",
                f"{resting} = {high:g} is less than {moving} = {low:g}",
                "what sticks would slip, and stick again at once",
                f"give a value of at least {low:g}, or leave {resting} out",
            )  # fmt: skip
    if turns and friction.reads_reaction and not friction.is_none and friction.radius is None:
        check.refuse(
            "model.friction_radius", f"{where}.radius", "the radius of the bearing is missing",
            "friction in a joint that turns is a torque: mu * radius * reaction", "give radius = .. in m",
        )  # fmt: skip


def _value(check: Checker, friction: Friction, name: str, where: str) -> float | None:
    formula: Formula | None = getattr(friction, name)
    return None if formula is None else check.value(formula, f"{where}.{name}")


def _check_laws(friction: Friction, door: Door) -> None:
    """Refuse words of both laws together."""
    if friction.force is None and friction.static is not None:
        _mixed(door, "static", "force")
    if friction.force is not None:
        for name in ("mu_static", "radius"):
            if getattr(friction, name) is not None:
                _mixed(door, name, "mu")
        if friction.mu.constant() != 0:
            _mixed(door, "force", "mu = 0")


def _mixed(door: Door, word: str, partner: str) -> None:
    door.refuse(
        "model.mixed_friction", word, f"{word} goes with {partner}, which is not what is given",
        "the strength of friction follows from the reaction, or it is given",
        "write mu, mu_static, radius; or force, static",
    )  # fmt: skip
