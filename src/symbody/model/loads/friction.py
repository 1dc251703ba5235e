"""`Friction`: dry friction along the one free direction of a joint, or between the surfaces of a contact."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final, final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.combinators import optional
from symbody.model.declarations.declaration import Declared
from symbody.model.declarations.fields import OptionalQuantity, Quantity, part
from symbody.model.declarations.formula_site import Scope
from symbody.model.numeric_checks import Domain, NumericChecks
from symbody.model.signals.block import difference

_STRENGTHS: Final = {
    name: Domain("model.negative_friction", f"the {word} {name} is {{value}}",
                 "friction always opposes the motion", "give a number that is not negative", 0.0)
    for word, names in (("coefficient", ("mu", "mu_static", "mu_y")), ("strength", ("force", "static")))
    for name in names
}  # fmt: skip
_SCALES: Final = {
    name: Domain("model.friction_scale", f"{name} is {{value}}", "it is a scale or a lever arm",
                 f"give a positive number, or leave {name} out", 0.0, above=True)
    for name in ("radius", "v0", "stribeck", "deflection", "damping_time")
}  # fmt: skip
_BREAKAWAY: Final = Domain(
    "model.friction_scale", "breakaway is {value}",
    "it is the share of the strength below which nothing slips",
    "give a number from 0 (LuGre's law, which creeps) to 0.99, or leave breakaway out", 0.0, most=0.99,
)  # fmt: skip
_ORDERS: Final = {
    resting: Domain("model.static_friction", f"{resting} is less than {moving}: {{formula}} is {{value}}",
                    "a sticking joint would slip and immediately stick again",
                    f"give a value of at least {moving}, or leave {resting} out", 0.0)
    for moving, resting in (("mu", "mu_static"), ("force", "static"))
}  # fmt: skip
_DOMAINS: Final = MappingProxyType({**_STRENGTHS, **_SCALES, "breakaway": _BREAKAWAY})


@final
@part
class Friction(Declared):
    """Dry friction in a joint, from its own reaction or of given strength; or in a contact.

    A prismatic joint is held back by ``mu*N``, a revolute joint by ``mu*radius*N``, where N is the magnitude
    of the reaction across the axis; or both by `force`. With `v0` the law is smooth, proportional to
    ``sin(atan(v/v0))``: 0.71 of its strength at `v0`; without it the joint sticks and slips by events. In a
    prismatic joint the moment it transmits, over `radius`, counts as one more component of its reaction;
    without `radius` forces alone count.

    In a contact it is ``mu N v/sqrt(v^2 + v0^2)`` against the slip v, with `mu_y` across x of the contact's
    frame. With `stribeck` the coefficient falls from `mu_static` to `mu` as
    ``mu + (mu_static - mu) exp(-(v/stribeck)^2)``.

    With `deflection` it has bristles instead, in joints and contacts: it deflects like a spring up to there,
    then slips, and needs neither `v0` nor events. Below `breakaway` nothing slips, so that what rests does
    not creep: the law of Dupont, Hayward, Armstrong and Altpeter (2002); ``breakaway=0`` is LuGre's (Canudas
    de Wit et al. 1995). The deflection, as a share of `deflection`, is a state.

    Examples
    --------
    >>> import symbody as sb
    >>> friction = sb.Friction(mu=0.3, mu_static=0.4)
    >>> rail = sb.Prismatic("rail", "ground", "Block", axis="x", coordinate="x", friction=friction)
    """

    mu: Quantity = Quantity(
        "Coefficient of the joint's reaction while it slides.", default=0, scope=Scope.LOAD
    )
    mu_static: OptionalQuantity = optional(
        Quantity("Coefficient up to which it sticks; default: mu.", scope=Scope.LOAD)
    )
    radius: OptionalQuantity = optional(
        Quantity("Radius of the bearing; required for a revolute joint.", unit="m")
    )
    v0: OptionalQuantity = optional(
        Quantity(
            "Speed scale of a smooth law; without it the joint sticks and slips by events.", unit="m/s, rad/s"
        )
    )
    force: OptionalQuantity = optional(
        Quantity("Friction force or torque, independent of the reaction.", unit="N, N m", scope=Scope.LOAD)
    )
    static: OptionalQuantity = optional(
        Quantity("Force or torque up to which it sticks.", unit="N, N m", scope=Scope.LOAD)
    )
    mu_y: OptionalQuantity = optional(
        Quantity("Coefficient of a contact along y of its frame; default: mu.", scope=Scope.LOAD)
    )
    stribeck: OptionalQuantity = optional(
        Quantity("Speed over which mu_static falls to mu; of contacts and bristles.", unit="m/s, rad/s")
    )
    deflection: OptionalQuantity = optional(
        Quantity("Deflection of bristles at which they break away: the law without events.", unit="m, rad")
    )
    damping_time: OptionalQuantity = optional(
        Quantity("Damping of bristles over their stiffness; default: 2 sqrt(deflection/9.81).", unit="s")
    )
    breakaway: OptionalQuantity = optional(
        Quantity("Share of the strength below which bristles do not slip; default: 0.7; 0: LuGre's law.")
    )

    def check(self, arguments: Arguments) -> None:
        """Note arguments of both laws given together."""
        if self.force is None and self.static is not None:
            _refuse_mixture(arguments, "static", "force")
        if self.force is not None:
            for name in ("mu_static", "radius"):
                if getattr(self, name) is not None:
                    _refuse_mixture(arguments, name, "mu")
            if self.mu.constant() != 0:
                _refuse_mixture(arguments, "force", "mu = 0")
        self._check_bristles(arguments)

    def _check_bristles(self, arguments: Arguments) -> None:
        """Note arguments of bristles without them, and those of other laws with them."""
        if self.deflection is None:
            for name in ("damping_time", "breakaway"):
                if getattr(self, name) is not None:
                    why, fix = "it is that of bristles", "give deflection = .., or leave it out"
                    what = f"{name} requires deflection, which is missing"
                    arguments.add("model.mixed_friction", name, what, why, fix)
            return
        if self.v0 is not None:
            what, why = "deflection and v0 are given", "with v0 friction is a function of the slip alone"
            arguments.add("model.mixed_friction", "deflection", what, why, "leave one of them out")
        check = NumericChecks({})
        for name in ("deflection", "damping_time", "breakaway"):
            if (formula := getattr(self, name)) is not None:
                _DOMAINS[name](check, formula, name)
        for problem in check.problems:
            arguments.add(problem.code, problem.where, problem.what, problem.why, problem.fix)
        word = "static" if self.force is not None else "mu_static"
        if (getattr(self, word) is None) != (self.stribeck is None):
            what = f"{word} and stribeck belong together"
            why = f"the strength falls from {word} over the speed stribeck"
            arguments.add("model.mixed_friction", word, what, why, "give both, or neither")

    @property
    def reads_reaction(self) -> bool:
        """Whether the joint's reaction decides its strength."""
        return self.force is None

    @property
    def is_smooth(self) -> bool:
        """Whether it is a function of velocity and states, without sticking."""
        return self.v0 is not None or self.has_bristles

    @property
    def has_bristles(self) -> bool:
        """Whether it deflects before it slips."""
        return self.deflection is not None and not self.is_none

    @property
    def strongest(self) -> Formula:
        """The coefficient, or the strength, up to which it sticks."""
        moving, resting = (self.mu, self.mu_static) if self.force is None else (self.force, self.static)
        return moving if resting is None else resting

    @property
    def is_none(self) -> bool:
        """Whether there is no friction at all."""
        return self.force is None and self.mu.constant() == 0 and self.mu_static is None


def check_friction(check: NumericChecks, friction: Friction, where: str, turns: bool) -> None:
    """Refuse friction with impossible numbers; `turns` says that it holds back an angle."""
    for name, domain in _DOMAINS.items():
        formula: Formula | None = getattr(friction, name)
        if formula is not None:
            domain(check, formula, f"{where}.{name}")
    for resting, low, high in (
        ("mu_static", friction.mu, friction.mu_static), ("static", friction.force, friction.static)
    ):  # fmt: skip
        if low is not None and high is not None:
            _ORDERS[resting](check, difference(high, low), f"{where}.{resting}")
    if turns and friction.reads_reaction and not friction.is_none and friction.radius is None:
        check.refuse(
            "model.friction_radius", f"{where}.radius", "the radius of the bearing is missing",
            "friction in a rotating joint is a torque: mu * radius * reaction", "give radius = .. in m",
        )  # fmt: skip


def _refuse_mixture(arguments: Arguments, word: str, partner: str) -> None:
    why = "the friction force is proportional to the reaction, or it is given directly"
    fix = "write mu, mu_static, radius; or force, static"
    arguments.add("model.mixed_friction", word, f"{word} requires {partner}, which is missing", why, fix)
