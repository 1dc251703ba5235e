"""The model file: TOML on disk, the same structure as JSON data for the ModelBuilder."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import symbody.formats as formats
from symbody.arguments import checked_arguments
from symbody.collection import without_collection
from symbody.errors import FormatError, ModelError, Problem, SymbodyError
from symbody.expr.language.formula import Formula
from symbody.formats.places import Locate, Path, line_locator, pointer, relocate
from symbody.formats.reading import parse_toml, read_text
from symbody.formats.schema import NEWER_SECTIONS, VERSION, check_structure
from symbody.formats.writing import write_text
from symbody.model.body import GROUND_FRAMES
from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.field import FileTarget, Node
from symbody.model.element import Element
from symbody.model.frame_index import element_labels
from symbody.model.model import KINDS, Model
from symbody.model.parts.expansion import model_content, own_content
from symbody.model.parts.include import Include
from symbody.model.registry import read_element, write_element
from symbody.model.shapes.shape import GROUND_SHAPES
from symbody.model.tables.inner_path import inner_path, saved_path

_PACKAGE: Final = __name__.partition(".")[0]


@checked_arguments
def load_model(path: str | os.PathLike[str]) -> Model:
    """Return the model in a TOML file.

    Parameters
    ----------
    path : str or path
        The file.

    Returns
    -------
    Model
        What it describes.

    Raises
    ------
    FormatError
        If the file cannot be read, is not TOML, or has keys and types that do not fit.
    ModelError
        If the mechanism it describes contradicts itself. Both list all problems, with their lines.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x")
    >>> import tempfile
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "cart.toml")
    ...     sb.save_model(sb.Model("cart", [rail]), path)
    ...     sb.load_model(path)
    Model('cart': 1 body, 1 joint)
    """
    where = os.fsdecode(path)
    if where.lower().endswith(".urdf"):
        raise FormatError(Problem("file.urdf", where, "it is not TOML", fix=f"write load_urdf({where!r})"))
    return model_from_toml(read_text(path), where=where)


@checked_arguments
def save_model(model: Model, path: str | os.PathLike[str]) -> None:
    """Write a model to a TOML file.

    Comments, order and ``[layout]`` of an existing model file are kept, and so is the old file, with ``.bak``
    appended to its name. The file is replaced in one step.

    Parameters
    ----------
    model : Model
        What is written.
    path : str or path
        The file, as ``"model.toml"``.

    Raises
    ------
    FormatError
        If the file cannot be written, or the existing one cannot be read; or if elements
        are of classes that are not symbody's. The file that was there is unchanged.

    Examples
    --------
    >>> import tempfile, pathlib, symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "cart.toml")
    ...     sb.save_model(sb.Model("cart", [rail]), path)
    ...     sb.load_model(path)
    Model('cart': 1 body, 1 joint)
    """
    _refuse_own_classes(model)
    old = "" if not os.path.lexists(path) or os.path.getsize(path) == 0 else read_text(path)
    folder = os.path.dirname(os.path.abspath(os.fsdecode(path)))
    write_text(path, _toml_text(_content(model, folder), old, folder))


def _refuse_own_classes(model: Model) -> None:
    """Refuse elements that no file can be read with."""
    problems = []
    for each in model.elements:
        if type(each).__module__.partition(".")[0] != _PACKAGE:
            where, word = f"{each.kind} {each.name}", type(each).__name__
            why = "its class is not part of the package, so files cannot be read back"
            fix = "keep the mechanism as a script, or add the class to the package"
            problems.append(Problem("file.own_class", where, f"model files cannot describe {word}", why, fix))
    if problems:
        raise FormatError(*problems)


@without_collection()
def model_from_toml(text: str, where: str = "model file") -> Model:
    """Return the model in a TOML text, which messages call `where`; faults as of `load_model`."""
    plain = text.removeprefix("\N{ZERO WIDTH NO-BREAK SPACE}").replace("\r\n", "\n")
    reading = (os.path.realpath(where),)
    return _model(parse_toml(plain, where), line_locator(plain, where), os.path.dirname(where), reading)


def model_to_toml(
    model: Model,
    onto: str = "",
    layout: Mapping[str, Any] | None = None,
    *,
    is_alone: bool = False,
    folder: str = "",
) -> str:
    """Return the TOML text of a model.

    Raises FormatError if the layout holds something that TOML cannot say.

    Parameters
    ----------
    onto : str
        Text of a model file; its comments, order and layout are kept where it still says the same.
    layout : mapping, optional
        Takes the place of ``[layout]``; None keeps it as it is.
    is_alone : bool
        Whether the text is to be read without the files that the model names: it then holds what is in them.
    folder : str
        Where `onto` stands, in which paths begin; "" leaves paths as they are.
    """
    text = _toml_text(_content(model, folder or None, is_alone=is_alone), onto, folder or None)
    return text if layout is None else _with_layout(text, layout)


def from_data(data: object, where: str = "", folder: str = "") -> Model:
    """Return the model of JSON data with the structure of the file; null means left out.

    Faults as of `load_model`, with JSON pointers such as ``#/joint/2/axis`` instead of lines.

    Parameters
    ----------
    where : str
        Stands before the pointers in messages.
    folder : str
        Where paths of meshes begin.
    """

    def locate(path: Path) -> str:
        return f"{where}{pointer(path)}"

    return _model(_drop_nulls(data), locate, folder)


def to_data(
    model: Model, layout: Mapping[str, Any] | None = None, *, is_alone: bool = False
) -> dict[str, Any]:
    """Return a model as JSON data with the structure of the file; formulas and numbers are texts.

    Where the data are to be read without the files that the model names, what is in these stands in them.
    """
    data = {key: _plain(node) for key, node in _content(model, is_alone=is_alone).items()}
    return data if layout is None else {**data, "layout": dict(layout)}


def read_layout(text: str, where: str = "model file") -> dict[str, Any]:
    """Return the ``[layout]`` of a TOML text, empty if there is none; a FormatError if it is not TOML."""
    layout = parse_toml(text.replace("\r\n", "\n"), where).get("layout", {})
    return layout if isinstance(layout, dict) else {}


def _model(data: object, locate: Locate, folder: str = "", reading: tuple[str, ...] = ()) -> Model:
    content = check_structure(data, locate)
    parts = read_includes(content.get("include", []), locate, folder, reading, _model)
    locate = parts.locate
    elements, problems = read_elements(content, KINDS, locate, folder)
    arguments = Arguments("model")
    fixed = content.get("ground", {})
    frames: Any = GROUND_FRAMES.from_file(fixed.get("frames", {}), arguments, "ground.frames", folder)
    shapes: Any = GROUND_SHAPES.from_file(fixed.get("shape", []), arguments, "ground.shape", folder)
    problems += relocate(arguments.problems, {"model": ()}, locate)
    if problems:
        raise ModelError(*problems)
    labels = element_labels(each for _, each in elements)
    bases: dict[str, Path] = {"model": (), **parts.paths}
    bases |= {labels[k]: path for k, (path, _) in enumerate(elements)}
    try:
        return Model(
            content["name"],
            [*(each for _, each in elements), *parts.includes],
            gravity=content.get("gravity", (0, 0, 0)),
            parameters=read_parameters(content),
            inputs=content.get("inputs", ()),
            initial=content.get("initial", {}),
            ground=frames,
            ground_shapes=shapes,
        )
    except ModelError as error:
        raise ModelError(*relocate(error.problems, bases, locate)) from None


def read_elements(
    content: Mapping[str, Any],
    kinds: Iterable[str],
    locate: Locate,
    folder: str = "",
    translate: Callable[[Mapping[str, Any]], Mapping[str, Any]] = lambda entry: entry,
) -> tuple[list[tuple[Path, Element]], list[Problem]]:
    """Return the elements of some kinds after their places in the file, and what is wrong with the others.

    Parameters
    ----------
    translate : callable
        Takes the table of an element, returns the one that is read.
    """
    elements: list[tuple[Path, Element]] = []
    problems: list[Problem] = []
    for kind in kinds:
        for k, entry in enumerate(content.get(kind, [])):
            try:
                elements.append(((kind, k), read_element(kind, translate(entry), folder)))
            except ModelError as error:
                problems += relocate(error.problems, {f"{kind} {entry['name']}": (kind, k)}, locate)
    return elements, problems


def read_parameters(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters of a file; "" is none."""
    return {name: None if x == "" else x for name, x in content.get("parameters", {}).items()}


def _content(model: Model, folder: str | None = None, *, is_alone: bool = False) -> dict[str, Node]:
    """Return what the file of a model says, without layout."""
    target = FileTarget(folder, is_alone)
    content: dict[str, Node] = {"name": model.name, "gravity": list(model.gravity)}
    said, includes = (model_content(model), ()) if is_alone else own_content(model)
    if said.inputs:
        content["inputs"] = list(said.inputs)
    if said.parameters:
        content["parameters"] = {
            name: "" if formula is None else formula for name, formula in said.parameters.items()
        }
    fixed: dict[str, Node] = {}
    if said.ground:
        fixed["frames"] = {name: frame.to_entry(target) for name, frame in said.ground.items()}
    if said.ground_shapes:
        fixed["shape"] = GROUND_SHAPES.to_file(None, said.ground_shapes, target) or []
    if fixed:
        content["ground"] = fixed
    for kind in KINDS:
        entries: list[Node] = [
            write_element(element, target) for element in said.elements if element.kind == kind
        ]
        if entries:
            content[kind] = entries
    if includes:
        content["include"] = [include_entry(include, folder) for include in includes]
    if said.initial:
        content["initial"] = {
            name: {"value": formula, "priority": "hold"} if name in said.initial.held else formula
            for name, formula in said.initial.items()
        }
    is_new = bool(said.initial.held) or any(section in content for section in NEWER_SECTIONS)
    return {"version": VERSION, **content} if is_new else content


def _toml_text(content: Mapping[str, Node], onto: str, folder: str | None = None) -> str:
    merged = _merge(content, onto.replace("\r\n", "\n"), folder) if onto.strip() else None
    return merged or formats.write_toml(content)


def _merge(content: Mapping[str, Node], onto: str, folder: str | None) -> str | None:
    """Return the changed text of a model file, or None if `onto` is none or does not take the changes."""
    where = os.path.join(folder or "", "model file")
    try:
        before = _content(model_from_toml(onto, where), folder)
        if before == content:  # to the byte, whatever the library makes of tables out of order
            return onto
        text = formats.write_toml(content, onto, before)
        return text if _content(model_from_toml(text, where), folder) == content else None
    except SymbodyError:
        return None


def _with_layout(text: str, layout: Mapping[str, Any]) -> str:
    try:
        return formats.write_layout(text, layout)
    except (TypeError, ValueError, RecursionError) as error:
        what = f"the layout cannot be written to a file: {error}"
        why = "TOML has strings, numbers, true and false, lists and tables, but no null"
        raise FormatError(Problem("file.layout", "layout", what, why, "remove such entries")) from error


def _plain(node: Node) -> Any:
    if isinstance(node, Formula):
        return node.text
    if isinstance(node, list):
        return [_plain(entry) for entry in node]
    return {name: _plain(entry) for name, entry in node.items()} if isinstance(node, dict) else node


def _drop_nulls(data: object) -> object:
    """Return data without null entries above the layout; a parameter that is null has no value."""
    if not isinstance(data, Mapping):
        return data
    parameters = data.get("parameters")
    kept = {key: value for key, value in data.items() if value is not None}
    for kind in KINDS:
        if isinstance(kept.get(kind), list):
            kept[kind] = [
                {key: value for key, value in entry.items() if value is not None}
                if isinstance(entry, Mapping) else entry
                for entry in kept[kind]
            ]  # fmt: skip
    if isinstance(parameters, Mapping):
        kept["parameters"] = {name: "" if value is None else value for name, value in parameters.items()}
    return kept


# Reads the model of JSON data: places, folder, and the files that are being read.
ReadModel = Callable[[object, Locate, str, tuple[str, ...]], Model]

KIND: Final = "include"


@dataclass(frozen=True, slots=True)
class IncludedParts:
    """The parts of a model file, and where things of theirs stand.

    Attributes
    ----------
    includes : tuple of Include
        One for each table.
    paths : mapping of label to path
        Where each included element stands, as a path that `locate` understands.
    locate : callable
        Places of the model file, behind them those of the part's file.
    """

    includes: tuple[Include, ...]
    paths: Mapping[str, Path]
    locate: Locate


def read_includes(
    entries: Sequence[Mapping[str, Any]],
    locate: Locate,
    folder: str,
    reading: tuple[str, ...],
    read: ReadModel,
) -> IncludedParts:
    """Return the parts of the tables of a model file; their faults have file and line of the part."""
    includes: list[Include] = []
    paths: dict[str, Path] = {}
    places: list[Locate] = []
    problems: list[Problem] = []
    for k, entry in enumerate(entries):
        path: Path = (KIND, k)
        paths[f"{KIND} {entry['prefix']}"] = path
        try:
            part, where = _read_part(entry, f"{locate((*path, 'file'))}, include {entry['prefix']}", folder,
                                     reading, read)  # fmt: skip
            given = {key: entry[key] for key in ("at", "connect", "share", "parameters") if key in entry}
            includes.append(Include(part, entry["prefix"], **given, file=entry["file"], folder=folder))
            places.append(where)
        except ModelError as error:
            problems += _fault_places(error.problems, entry, path, locate)
            continue
        for element in part.elements:
            own = [other for other in part.elements if other.kind == element.kind]
            paths[f"{element.kind} {entry['prefix']}_{element.name}"] = (
                *path, "of", len(places) - 1, element.kind, own.index(element)
            )  # fmt: skip
    if problems:
        raise ModelError(*problems)

    def locate_part(path: Path) -> str:
        if path[:1] != (KIND,) or path[2:3] != ("of",):
            return locate(path)
        return f"{locate(path[:2])}, {places[int(path[3])](path[4:])}"

    return IncludedParts(tuple(includes), paths, locate_part)


def _fault_places(
    problems: Sequence[Problem], entry: Mapping[str, Any], path: Path, locate: Locate
) -> Sequence[Problem]:
    """Return faults of the table with its line; those of the part's file have theirs."""
    label = f"{KIND} {entry['prefix']}"
    of_table = all(problem.where.startswith(label) for problem in problems)
    return relocate(problems, {label: path}, locate) if of_table else problems


def _read_part(
    entry: Mapping[str, Any], where: str, folder: str, reading: tuple[str, ...], read: ReadModel
) -> tuple[Model, Locate]:
    """Return the model of a part's file, and what finds lines in it."""
    file = str(entry["file"])
    place = inner_path(file, folder, where)
    if place in reading:
        names = [os.path.basename(name) for name in (*reading[reading.index(place) :], place)]
        what = f"the file includes itself: {' -> '.join(names)}"
        why = "a part would contain itself endlessly"
        raise ModelError(Problem("include.circle", where, what, why, "remove one of these includes"))
    shown = os.path.join(folder, file)
    try:
        text = read_text(place)
        places = line_locator(text, shown)
        return read(parse_toml(text, shown), places, os.path.dirname(shown), (*reading, place)), places
    except FormatError as error:
        raise ModelError(*error.problems) from error


def include_entry(include: Include, folder: str | None) -> dict[str, Node]:
    """Return the table of an include; its path leads from `folder`, None leaves it as it is.

    Raises FormatError if the part lies outside of the folder.
    """
    where = f"include {include.prefix}, file"
    place = saved_path(include.file, include.folder, folder, where, "part", "it")
    entry: dict[str, Node] = {"file": place, "prefix": include.prefix}
    if include.at.full_name != "ground":
        entry["at"] = include.at.full_name
    if include.share:
        entry["share"] = list(include.share)
    for key in ("connect", "parameters"):
        values = getattr(include, key)
        if values:
            entry[key] = dict(values)
    return entry
