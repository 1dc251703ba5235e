"""`Element`: anything in a model that has a name; and `FrameRef`: how it refers to frames."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from symbody.model.declarations.declaration import Declared
from symbody.model.declarations.fields import ElementName, part
from symbody.model.naming import CENTRE, GROUND

if TYPE_CHECKING:
    from symbody.model.signals.signal import Signal


@part
class Element(Declared):
    """A named part of a mechanism; frozen data.

    Attributes
    ----------
    kind : str
        The word for it in messages and model files: ``"joint"``.
    word : str
        The type in model files, where the kind has several; by default the name of the class.
    group : str
        What the diagram editor calls its group; by default the kind.
    outputs : mapping of kind to tuple of str
        What follows its name in the names of outputs of a kind: ``("",)`` if nothing does.
    effort_unit : str
        Of its effort; of several with commas, that along displacements first.
    has_frame : bool
        Whether there is a frame of its name, in the point of contact.
    """

    mark: ClassVar[str] = ", "
    kind: ClassVar[str]
    word: ClassVar[str] = ""
    group: ClassVar[str] = ""
    outputs: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType({})
    effort_unit: ClassVar[str] = ""
    has_frame: ClassVar[bool] = False

    name: ElementName = ElementName("Unique among the elements of the model.")

    def label(self) -> str:
        """Return kind and name."""
        return f"{self.kind} {self.name}"

    @property
    def signals(self) -> tuple[Signal, ...]:
        """The signals that it stands for, or that its states are."""
        return ()

    @property
    def compliant_gaps(self) -> Mapping[str, bool]:
        """The gaps, outputs or formulas, below which it has a force, and whether each is an angle."""
        return {}

    def output_words(self, kind: str) -> tuple[str, ...]:
        """Return what may follow its name in outputs of a kind; none if it has no such output."""
        return self.outputs.get(kind, ())


@dataclass(frozen=True, slots=True, repr=False)
class FrameRef:
    """A frame of a body, or of the ground.

    Attributes
    ----------
    body : str
        Name of the body, or ``"ground"``.
    frame : str
        Name of the frame on it; ``""`` is the centre of mass, or the ground's origin.
    body_object : Element or None
        The body itself, where a script gave the object; the model takes it over and clears this.
    """

    body: str
    frame: str = ""
    body_object: Element | None = field(default=None, compare=False, repr=False)

    @property
    def full_name(self) -> str:
        """The address as text: ``"Body"`` or ``"Body.Frame"``."""
        return f"{self.body}.{self.frame}" if self.frame else self.body

    def __str__(self) -> str:
        return self.full_name

    def __repr__(self) -> str:
        return repr(self.full_name)


def make_frame_ref(body: str, point: str = "", carried: Element | None = None) -> FrameRef:
    """Return an address in its one spelling: ground in lower case, the centre of mass left out."""
    is_ground = body.lower() == GROUND
    return FrameRef(GROUND if is_ground else body, "" if point == CENTRE else point, carried)
