"""`Include`: a model that is a part of another, under names with a prefix."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

from symbody.arguments import checked_arguments
from symbody.errors import nearest
from symbody.expr.language.formula import Formula
from symbody.model.body import FrameLike, read_frame_ref
from symbody.model.declarations.arguments import Arguments, Value
from symbody.model.element import FrameRef
from symbody.model.frozen_mapping import FrozenMapping

if TYPE_CHECKING:
    from symbody.model.model import Model


@final
@dataclass(frozen=True, slots=True, init=False)
class Include:
    """A model as a part of another: its elements and symbols under names with a prefix.

    Parameters
    ----------
    part : Model
        The part; its gravity is that of the whole.
    prefix : str
        ``"FL"`` makes ``FL_knee`` of the joint or parameter ``knee``.
    at : Body, ``body["frame"]`` or text
        What is the ground of the part.
    connect : mapping of str to str
        Inputs of the part to symbols or formulas of the whole; signals of the part to the names they get.
    share : iterable of str
        Parameters and inputs that keep their names, so that several parts and the whole share them.
    parameters : mapping of name to number or formula
        Values in place of those of the part, in symbols of the whole.
    file : str
        The part's file by its path from `folder`, where it was read from one: `save_model` writes this.
    folder : str
        Where the path starts.

    Raises
    ------
    ModelError
        With every port, parameter or shared name that the part does not have.

    Examples
    --------
    >>> import symbody as sb
    >>> shank = sb.Body("Shank", inertia=(0, 0, 0.1))
    >>> leg = sb.Model("leg", [sb.Revolute("knee", "ground", shank, coordinate="phi")])
    >>> robot = sb.Model("robot", [sb.Include(leg, "L"), sb.Include(leg, "R")])
    >>> [joint.name for joint in robot.joints]
    ['L_knee', 'R_knee']
    """

    part: Model
    prefix: str
    at: FrameRef
    connect: FrozenMapping[Formula]
    share: tuple[str, ...]
    parameters: FrozenMapping[Formula]
    file: str
    folder: str

    @checked_arguments
    def __init__(
        self,
        part: Model,
        prefix: str,
        at: FrameLike = "ground",
        connect: Mapping[str, Value] | None = None,
        share: Iterable[str] = (),
        parameters: Mapping[str, Value] | None = None,
        file: str = "",
        folder: str = "",
    ) -> None:
        arguments = Arguments(f"include {prefix}")
        at_frame = read_frame_ref(arguments, at, "at")
        values = {
            "part": part,
            "prefix": arguments.symbol_name(prefix, "prefix"),
            "at": FrameRef(at_frame.body, at_frame.frame),
            "connect": arguments.table(connect or {}, "connect", arguments.formula),
            "share": tuple(map(str, arguments.items(share, "share"))),
            "parameters": arguments.table(parameters or {}, "parameters", arguments.formula),
            "file": file,
            "folder": folder,
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)
        self._check(arguments)
        arguments.raise_all()

    @property
    def ports(self) -> tuple[str, ...]:
        """What may be connected: inputs and signals of the part."""
        signals = (*self.part.signals, *self.part.held_signals)
        return (*self.part.inputs, *(signal.name for signal in signals))

    def _check(self, arguments: Arguments) -> None:
        shared = (*self.part.parameters, *self.part.inputs)
        kinds = (
            ("connect", self.connect, self.ports, "port", "inputs and signals of a part are its ports"),
            ("parameters", self.parameters, tuple(self.part.parameters), "parameter", ""),
            ("share", self.share, shared, "parameter or input", "only parameters and inputs can be shared"),
        )
        for key, names, known, word, why in kinds:
            for name in names:
                if name not in known:
                    what = f"the part {self.part.name!r} has no {word} {name!r}"
                    arguments.add(f"include.{key}", f"{key}.{name}", what, why, nearest(name, known))
        for name, formula in self.connect.items():
            if name not in self.part.inputs and formula.names != (formula.text,):
                what = f"the signal {name} cannot become {formula.text!r}"
                why = "a signal of the part is an output: connect it by giving it a name in the whole model"
                fix = f'write {name} = "another_name"'
                arguments.add("include.connect", f"connect.{name}", what, why, fix)
        for name in self.share:
            if name in self.connect or name in self.parameters:
                what = f"{name} is shared and also has its own value"
                arguments.add("include.share", "share", what, "", "remove one of them")
