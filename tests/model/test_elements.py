"""Elements as they declare themselves: signatures, documentation, forms, tables of the docs."""

from __future__ import annotations

import inspect
import runpy
from pathlib import Path

import pytest

import symbody as sb
from symbody.errors import UsageError
from symbody.model.declarations.declaration import Declared
from symbody.model.element import Element
from symbody.model.model import KINDS
from symbody.model.registry import element_types
from symbody.model.shapes.shape import shape_types

DOCS = Path(__file__).parents[2] / "docs"
KINDS_OF_ELEMENTS = [each for kind in KINDS for each in element_types(kind).values()]
DECLARED: list[type[Declared]] = [
    *KINDS_OF_ELEMENTS,
    *shape_types().values(),
    sb.Frame,
    sb.Drive,
    sb.Friction,
]


@pytest.mark.parametrize("kind", DECLARED)
def test_the_documentation_lists_every_argument(kind: type[Declared]) -> None:
    text = inspect.getdoc(kind) or ""
    signature = inspect.signature(kind)
    assert list(signature.parameters) == list(kind.fields)
    for name, parameter in signature.parameters.items():
        assert f"\n{name} : " in text and isinstance(parameter.annotation, str)
    assert text.index("Parameters\n----------") < text.index("Raises\n------") and kind.summary()


@pytest.mark.parametrize("kind", KINDS_OF_ELEMENTS)
def test_every_element_is_public(kind: type[Element]) -> None:
    assert getattr(sb, kind.__name__) is kind


def test_arguments_may_stand_by_position() -> None:
    signature = inspect.signature(sb.Screw)
    assert str(signature.parameters["axis"]) == "axis: 'str | Iterable[Value]' = 'z'"
    screw = sb.Screw("s", "ground", "Nut", "p", "x", "theta")
    assert screw == sb.Screw(name="s", start="ground", end="Nut", pitch="p", axis="x", coordinate="theta")
    assert screw != sb.Screw("s", "ground", "Nut", "p", "y", "theta") and screw != sb.Weld(
        "s", "ground", "Nut"
    )


def test_what_no_reader_expects_names_the_argument() -> None:
    class Odd:
        def __bool__(self) -> bool:
            raise ValueError("neither true nor false")

    with pytest.raises(UsageError, match="Body, argument frames"):
        sb.Body("b", frames=Odd())  # type: ignore[arg-type]


def test_the_recipe_for_a_joint_works(tmp_path: Path) -> None:
    recipe = (DOCS / "extending_joint.md").read_text(encoding="utf-8")
    file = tmp_path / "point_on_circle.py"
    file.write_text(recipe.partition("```python\n")[2].partition("```")[0], encoding="utf-8")
    kind = runpy.run_path(str(file))["PointOnCircle"]
    joint = kind("ring", "ground", "Bead", "r", axis="x", coordinates=["s", "a", "b", "c"])
    assert [component.text for component in joint.shift()] == ["0", "(r)*cos(s/(r))", "(r)*sin(s/(r))"]
    assert joint.locked_directions == 2 and [site.path for site in joint.formula_sites()] == ["radius"]
    with pytest.raises(sb.ModelError, match="model.no_length"):
        sb.Model("m", [sb.Body("Bead", mass=1), kind("ring", "ground", "Bead", -1)])


@pytest.mark.parametrize("page", ["joints.md", "constraints.md", "forces.md", "outputs.md"])
def test_the_tables_of_elements_are_current(page: str) -> None:
    listing = runpy.run_path(str(DOCS / "list_elements.py"))
    table = listing["PAGES"][page]()
    assert table in (DOCS / page).read_text(encoding="utf-8"), "run: python docs/list_elements.py"
