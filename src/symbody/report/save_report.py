"""`save_report`: the derivation of a mechanism as a file that people read."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Final

from symbody.arguments import checked_arguments
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.equation_sections import SHOWN_DIGITS
from symbody.equations.outputs.printed_equations import checked_digits
from symbody.errors import EnvironmentFault, Problem, UsageError, nearest
from symbody.formats.reading import read_text
from symbody.model.model import Model
from symbody.report.behaviour_sections import (
    code_section,
    equilibrium_section,
    motion_section,
    origin_section,
)
from symbody.report.document import Figure, PictureKind, ReportContent, ReportSection
from symbody.report.equation_sections import (
    constraints_section,
    dynamics_section,
    equations_section,
    kinematics_section,
    reactions_section,
    with_digits_note,
)
from symbody.report.html_document import html_document, html_pieces
from symbody.report.latex_document import latex_document, latex_pieces
from symbody.report.markdown_document import markdown_document, markdown_pieces, notebook_document
from symbody.report.model_sections import (
    coordinates_section,
    graph_section,
    mechanism_section,
    parameters_section,
    parts_section,
)
from symbody.report.setting import Setting
from symbody.report.template import fill_template
from symbody.simulation.results.trajectory import Trajectory

# In the order of a derivation.
SECTIONS: Final[Mapping[str, Callable[[Setting], ReportSection]]] = {
    "mechanism": mechanism_section,
    "graph": graph_section,
    "parts": parts_section,
    "parameters": parameters_section,
    "coordinates": coordinates_section,
    "kinematics": kinematics_section,
    "constraints": constraints_section,
    "dynamics": dynamics_section,
    "equations": equations_section,
    "reactions": reactions_section,
    "equilibrium": equilibrium_section,
    "motion": motion_section,
    "code": code_section,
    "origin": origin_section,
}
# What LaTeX reads otherwise in the name of a picture.
_UNREADABLE: Final = re.compile(r"[%#~^&$\\{}\"]")
_SUFFIXES: Final = (".html", ".tex", ".md", ".ipynb")


@checked_arguments
def save_report(
    eqs: EquationSet,
    path: str | PathLike[str],
    run: Trajectory | None = None,
    *,
    sections: Sequence[str] | None = None,
    parameters: Mapping[str, Value] | None = None,
    title: str | None = None,
    template: str | PathLike[str] | None = None,
    digits: int | None = SHOWN_DIGITS,
) -> None:
    """Write the derivation of a mechanism in the order of a textbook.

    Formulas longer than 400 operations are written in named shared parts; those that nobody reads are
    counted.

    Parameters
    ----------
    eqs : EquationSet
        The equations.
    path : str or path
        The suffix decides: ``.html`` one page without script or request, ``.tex`` for pdflatex, ``.md``
        Markdown with formulas between dollars, ``.ipynb`` a notebook. Pictures of ``.tex`` and ``.md`` go
        into a folder ``NAME_pictures`` beside the file.
    run : Trajectory, optional
        A motion to be shown, with its energies and how far constraints are open.
    sections : sequence of str, optional
        Which ones, in the order given: mechanism, graph, parts, parameters, coordinates, kinematics,
        constraints, dynamics, equations, reactions, equilibrium, motion, code, origin. By default all.
    parameters : mapping of name to value, optional
        Values in place of the model's, for picture and equilibrium; by default those of `run`.
    title : str, optional
        By default the name of the model.
    template : path, optional
        A text file around the report, in HTML, LaTeX or Markdown as the suffix of `path` says: ``{{ body }}``
        in it is replaced by all sections, ``{{ title }}`` by the title, and the name of a section, as in
        ``{{ dynamics }}``, by that one. Pages have ``{{ contents }}``, ``{{ style }}`` and ``{{ policy }}``,
        too, LaTeX the ``{{ packages }}`` it needs.
    digits : int, optional
        Significant digits of computed numbers in formulas; None for all.

    Raises
    ------
    UsageError
        A suffix, a section or a parameter that does not exist; a section "motion" without a motion; a
        motion of other equations; a template for a notebook, or one with unknown placeholders.
    FormatError, EnvironmentFault
        If the template cannot be read; a file cannot be written, or nbformat is missing for a notebook.

    Examples
    --------
    >>> sb.save_report(eqs, "slider_crank.html", run=sb.simulate(eqs, (0, 2)))  # doctest: +SKIP
    """
    target = Path(path)
    _check(eqs, target, sections, run, parameters or {}, template)
    frame = None if template is None else (read_text(template), str(template))
    values = parameters if parameters is not None else run.parameters if run is not None else {}
    chosen = tuple(SECTIONS if sections is None else sections)
    _write(_content(Setting(eqs, run, values, checked_digits(digits)), chosen, title), target, frame)


def _content(setting: Setting, chosen: Sequence[str], title: str | None) -> ReportContent:
    parts = tuple(part for part in (SECTIONS[name](setting) for name in chosen) if part.blocks)
    parts = with_digits_note(setting, parts)
    return ReportContent(title or setting.eqs.model.name, parts)


def _check(
    eqs: EquationSet,
    path: Path,
    sections: Sequence[str] | None,
    run: Trajectory | None,
    parameters: Mapping[str, Value],
    template: object,
) -> None:
    problems = []
    if template is not None and path.suffix.lower() == ".ipynb":
        what = "notebooks have no template"
        problems.append(
            Problem(
                "report.template_kind", str(path), what, fix="remove template, or write .html, .tex or .md"
            )
        )
    if run is None and "motion" in (sections or ()):
        what = "there is no motion to show"
        fix = "give run=simulate(eqs, ...), or remove the section"
        problems.append(Problem("report.no_motion", "sections", what, fix=fix))
    if path.suffix.lower() not in _SUFFIXES:
        what = f"{path.suffix!r} is not a kind of report" if path.suffix else "the name has no suffix"
        problems.append(
            Problem("report.format", str(path), what, fix=f"end the name with one of {', '.join(_SUFFIXES)}")
        )
    for name in sections or ():
        if name not in SECTIONS:
            what = f"there is no section {name!r}"
            why = f"sections are {', '.join(SECTIONS)}"
            problems.append(Problem("report.section", "sections", what, why, nearest(name, SECTIONS)))
    if run is not None and run.coordinate_names != eqs.coordinate_names:
        names = [", ".join(x.coordinate_names) for x in (run, eqs)]
        what = f"the motion has coordinates {names[0]}, not {names[1]}"
        problems.append(Problem("report.run", "run", what, fix="simulate these equations"))
    if not isinstance(eqs.model, Model):
        what = "these equations were assembled by hand: there is no model with bodies and joints to report on"
        problems.append(Problem("report.by_hand", "eqs", what, fix="eqs.text() and eqs.latex() print them"))
    else:
        values = eqs.model.parameters
        problems += [
            Problem(
                "parameters.unknown", name, f"the model has no parameter {name!r}", "", nearest(name, values)
            )
            for name in parameters if name not in values
        ]  # fmt: skip
    if problems:
        raise UsageError(*problems)


def _write(document: ReportContent, path: Path, template: tuple[str, str] | None) -> None:
    try:
        _write_files(document, path, template)
    except OSError as error:
        fix = "choose an existing folder with write permission"
        what = f"the report cannot be written: {error.strerror}"
        raise EnvironmentFault(Problem("report.unwritable", str(path), what, fix=fix)) from error


def _write_files(document: ReportContent, path: Path, template: tuple[str, str] | None) -> None:
    suffix = path.suffix.lower()
    if suffix == ".ipynb":
        text = notebook_document(document)
    elif template is not None:
        text = fill_template(template[0], _pieces(document, path), template[1])
    elif suffix == ".html":
        text = html_document(document)
    else:
        text = (latex_document if suffix == ".tex" else markdown_document)(document, _folder(path).name)
    if suffix in (".tex", ".md"):
        _write_pictures(document, _folder(path), "pdf" if suffix == ".tex" else "svg")
    path.write_text(text, encoding="utf-8", newline="\n")


def _pieces(document: ReportContent, path: Path) -> dict[str, str]:
    """Return what a template of this kind of file may contain; sections that are left out are empty."""
    suffix = path.suffix.lower()
    if suffix == ".html":
        pieces = html_pieces(document)
    else:
        pieces = (latex_pieces if suffix == ".tex" else markdown_pieces)(document, _folder(path).name)
    return pieces | {name: "" for name in SECTIONS if name not in pieces}


def _folder(path: Path) -> Path:
    """Return where pictures go that are files of their own."""
    stem = _UNREADABLE.sub("-", path.stem) if path.suffix.lower() == ".tex" else path.stem
    return path.with_name(f"{stem}_pictures")


def _write_pictures(document: ReportContent, folder: Path, kind: PictureKind) -> None:
    figures = [block for part in document.sections for block in part.blocks if isinstance(block, Figure)]
    if figures:
        folder.mkdir(exist_ok=True)
    for figure in figures:
        (folder / f"{figure.name}.{kind}").write_bytes(figure.draw(kind))
