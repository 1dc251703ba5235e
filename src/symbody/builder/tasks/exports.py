"""A model in another form: Python, C, LaTeX, a page that shows its motion, or an FMU."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType
from typing import Any, Final

from symbody.analysis.configurations.assembly import assemble
from symbody.builder.file_names import file_stem
from symbody.builder.page_problems import page_notes
from symbody.builder.task_failure import Report
from symbody.builder.tasks.equations import all_tabs
from symbody.builder.tasks.reading import complete_model
from symbody.builder.tasks.simulation import kept_run
from symbody.equations.form import form_equations
from symbody.fmu.export import save_fmu
from symbody.formats.python_script import model_to_script
from symbody.model.model import Model
from symbody.simulation.programs.generate_code import generate_code
from symbody.visual.viewer.animation import make_animation
from symbody.visual.viewer.page import page_data, page_text

Answer = dict[str, Any]

_PREAMBLE: Final = r"""\documentclass{article}
\usepackage{amsmath}
\allowdisplaybreaks
\setcounter{MaxMatrixCols}{40}
"""


def export_model(payload: Mapping[str, Any], report: Report) -> Answer:
    """Return the name of a file and its text; of an FMU its bytes in base 64, and notes."""
    report("writing", None)
    name = file_stem(str(payload["data"].get("name") or "model"))
    if payload["kind"] == "fmu":
        return _fmu(payload, f"{name}.fmu")
    ending, make = _MAKERS[payload["kind"]]
    return {"name": f"{name}{ending}", "text": make(payload)}


def _fmu(payload: Mapping[str, Any], name: str) -> Answer:
    with TemporaryDirectory() as folder:
        fmu = save_fmu(form_equations(_model(payload)), Path(folder, name))
        content = fmu.path.read_bytes()
    where = ", ".join(fmu.platforms) or "sources alone"
    summary = f"{name}: FMI {fmu.version}, {len(fmu.variables)} variables, {where}"
    return {
        "name": name,
        "base64": b64encode(content).decode("ascii"),
        "notes": page_notes([summary, *fmu.notes], payload["data"]),
    }


def _model(payload: Mapping[str, Any]) -> Model:
    return complete_model(payload["data"], payload["folder"])


def _python(payload: Mapping[str, Any]) -> str:
    return model_to_script(_model(payload))


def _c(payload: Mapping[str, Any]) -> str:
    eqs = form_equations(_model(payload))
    outputs = ["xdot", "mass_matrix", "forcing", *(["constraints"] if eqs.multiplier_names else [])]
    return generate_code(eqs, outputs)


def _latex(payload: Mapping[str, Any]) -> str:
    """Return a document with all equations that are short enough to be read."""
    tabs = all_tabs({**payload, "options": {}})
    lines = [_PREAMBLE, f"\\title{{{_plain(str(payload['data'].get('name') or 'Model'))}}}", "\\date{}"]
    lines += ["\\begin{document}", "\\maketitle"]
    for tab in tabs:
        written = [block for block in tab["blocks"] if block["latex"]]
        if written:
            lines.append(f"\\section{{{_plain(tab['name'])}}}")
        for block in written:
            lines.append(f"\\subsection*{{{_plain(block['title'])}}}")
            lines += [f"{_display(part)}\n" for part in block["latex"].split("\n\n")]
    return "\n".join([*lines, "\\end{document}", ""])


def _display(formula: str) -> str:
    """Return a formula on lines of its own; `aligned` cannot be broken over pages, `align*` can."""
    if formula.startswith("\\begin{aligned}"):
        return formula.replace("{aligned}", "{align*}")
    return f"\\[\n{formula}\n\\]"


def _plain(text: str) -> str:
    """Return a text in which LaTeX sees no commands."""
    return "".join(_ESCAPED.get(letter, letter) for letter in text if letter.isprintable())


_ESCAPED: Final[Mapping[str, str]] = MappingProxyType(
    {
        "\\": r"\textbackslash{}",
        "^": r"\textasciicircum{}",
        "~": r"\textasciitilde{}",
        **{letter: f"\\{letter}" for letter in "{}$&#%_"},
    }
)


def _html(payload: Mapping[str, Any]) -> str:
    """Return a page that shows the run of this process, or the mechanism as it stands at the start."""
    finished = kept_run()
    if finished is not None:
        options = {"view": "auto", "theme": "auto", "speed": 1.0}
        return page_text(page_data(finished.scene, finished.motion, finished.scene.name, options))
    state = assemble(form_equations(_model(payload)))
    return make_animation(state, None, "none", (), None, None, None, {"view": "auto", "theme": "auto"}).html


_MAKERS: Final[Mapping[str, tuple[str, Callable[[Mapping[str, Any]], str]]]] = MappingProxyType(
    {"python": (".py", _python), "c": (".c", _c), "latex": (".tex", _latex), "html": (".html", _html)}
)
