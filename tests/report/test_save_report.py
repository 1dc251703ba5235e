"""Reports: the same bytes each time, formulas that are those of the graph, nothing but text from names."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pytest

import symbody as sb
from tests.mechanisms import example

EXAMPLES = Path(__file__).parents[2] / "examples"
NAMES = sorted(path.stem for path in EXAMPLES.glob("*/*.toml") if path.stem == path.parent.name)
FAST = ("slider_crank", "spinning_top", "dc_motor_arm")


class Page(HTMLParser):
    """Counts tags, and collects the texts beside formulas."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.sources: list[str] = []
        self.formulas: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.sources += [value or "" for name, value in attrs if name in ("src", "href")]
        self.formulas += [value or "" for name, value in attrs if name == "data-formula"]


def write(eqs: sb.EquationSet, path: Path, **words: object) -> str:
    sb.save_report(eqs, path, **words)  # type: ignore[arg-type]
    return path.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "name", [*FAST, *(pytest.param(x, marks=pytest.mark.exhaustive) for x in NAMES if x not in FAST)]
)
def test_pages_of_examples(name: str, tmp_path: Path) -> None:
    eqs = example(name)
    text = write(eqs, tmp_path / "one.html")
    assert write(eqs, tmp_path / "two.html") == text
    page = Page(text)
    assert "script" not in page.tags
    assert all(source.startswith(("data:", "#")) for source in page.sources)
    assert page.tags.count("section") >= 11
    assert page.formulas


def test_a_report_begins_with_a_summary_and_ends_with_costs(tmp_path: Path) -> None:
    """A summary first, a capital letter, numbered equations, names typeset in notes, costs at the end."""
    eqs = example("four_bar")
    text = write(eqs, tmp_path / "x.html")
    assert "<p>Four-bar has 1 degree of freedom.</p>" in text
    assert text.index("<td>Crank, Coupler, Rocker</td>") < text.index("<figure>")
    assert text.index('id="equations"') < text.index("Operations of each output")
    assert "counter(equation)" in text and "dropped (lambda_C_3" not in text
    assert "set to 0: <math" in text and "by pivoting: <math" in text  # names at the end of a sentence
    assert "<td>Coupler.C \u2192 Rocker.C</td><td></td>" in text  # a cut joint has no coordinates
    assert "kg\u00b7m\u00b2" in text and "kg m" not in text and "N m" not in text
    tex = write(eqs, tmp_path / "x.tex", sections=["equations"])
    equations = len(eqs.speed_names) + len(eqs.multiplier_names)
    rows = [row for part in re.findall(r"begin{align}(.*?)end{align}", tex, re.DOTALL)
            for row in part.strip("\n\\").split("\\\\\n")]  # fmt: skip
    assert sum(r"\notag" not in row for row in rows) == equations
    assert r"($\lambda_{C,3}$" in write(eqs, tmp_path / "y.tex", sections=["coordinates"])


def test_every_kind_of_file(tmp_path: Path) -> None:
    eqs = example("slider_crank")
    run = sb.simulate(eqs, (0, 0.2))
    tex = write(eqs, tmp_path / "x.tex", run=run)
    for picture in re.findall(r"\\includegraphics\[[^]]*\]\{([^}]*)\}", tex):
        assert (tmp_path / picture).read_bytes().startswith(b"%PDF")
    assert tex.count(r"\begin{") == tex.count(r"\end{")
    markdown = write(eqs, tmp_path / "x.md", run=run)
    pictures = re.findall(r"!\[[^]]*\]\(([^)]*)\)", markdown)
    assert len(pictures) == 4
    assert all((tmp_path / picture).is_file() for picture in pictures)
    nbformat = pytest.importorskip("nbformat")
    sb.save_report(eqs, tmp_path / "x.ipynb", run)
    nbformat.validate(nbformat.read(tmp_path / "x.ipynb", as_version=4))


def test_formulas_are_those_of_the_graph(tmp_path: Path) -> None:
    eqs = example("slider_crank")
    page = Page(write(eqs, tmp_path / "x.html", sections=["dynamics"]))
    parameters = {str(name): 0.5 + 0.1 * k for k, name in enumerate(eqs.parameters)}
    point = (0.0, [0.3, 0.4, 0.5], [0.6, 0.7, 0.8], [0.9])
    names = ["mass_matrix", "forcing", "jacobian", "gamma"]
    values = sb.compile(eqs, names, parameters=parameters)(*point)
    texts = [text.split("\n") for text in page.formulas]
    for lines, entries in zip(texts, values, strict=True):
        read = sb.compile(eqs, lines, parameters=parameters)(*point)
        np.testing.assert_allclose(read, np.ravel(entries), rtol=1e-13, atol=1e-14)


def test_names_are_text(tmp_path: Path) -> None:
    parts = [sb.Body("B", mass=1), sb.Prismatic("P", "ground", "B", axis="z", coordinate="z")]
    eqs = sb.form_equations(sb.Model('<b>&"m"</b> $x_1$ \\end', parts, notes=["<i>"]))
    text = write(eqs, tmp_path / "x.html")
    assert "<b>" not in text
    assert "<i>" not in text
    assert "&lt;b&gt;" in text
    assert r"\$x\_1\$ \textbackslash{}end" in write(eqs, tmp_path / "x.tex")
    assert "&lt;b&gt;" in write(eqs, tmp_path / "x.md")


def test_sections_are_chosen(tmp_path: Path) -> None:
    text = write(
        example("slider_crank"), tmp_path / "x.html", sections=["equations", "parameters"], title="Mine"
    )
    assert re.findall(r'<section id="(\w+)"', text) == ["equations", "parameters"]
    assert "<h1>Mine</h1>" in text


def test_missing_values_are_said(tmp_path: Path) -> None:
    parts = [sb.Body("B", mass="m"), sb.Prismatic("P", "ground", "B", coordinate="x")]
    text = write(sb.form_equations(sb.Model("bare", parts, parameters={"m": None})), tmp_path / "x.html")
    assert "No picture" in text
    assert "no value" in text


@pytest.mark.exhaustive
def test_large_mechanisms_are_counted(tmp_path: Path) -> None:
    frames = {"P": sb.Frame(at=(-0.5, 0, 0)), "Q": sb.Frame(at=(0.5, 0, 0))}
    bodies = [sb.Body(f"B{k}", mass=1, inertia=(0, 0, 1), frames=frames) for k in range(16)]
    joints = [
        sb.Revolute(f"J{k}", f"B{k - 1}.Q" if k else "ground", f"B{k}.P", coordinate=f"a{k}")
        for k in range(16)
    ]
    text = write(sb.form_equations(sb.Model("chain", [*bodies, *joints], (0, -9.81, 0))), tmp_path / "x.html")
    assert "too large for the report" in text
    assert len(text) < 3_000_000


@pytest.mark.parametrize(
    ("words", "code"),
    [
        ({"path": "x.docx"}, "report.format"),
        ({"path": "x"}, "report.format"),
        ({"path": "x.html", "sections": ["dynamic"]}, "report.section"),
        ({"path": "x.html", "run": "other"}, "report.run"),
        ({"path": "x.html", "sections": ["motion"]}, "report.no_motion"),
        ({"path": "x.ipynb", "template": "x.txt"}, "report.template_kind"),
        ({"path": "x.html", "parameters": {"no_such": 1}}, "parameters.unknown"),
    ],
)
def test_bad_arguments(words: dict[str, object], code: str, tmp_path: Path) -> None:
    eqs = example("slider_crank")
    if words.get("run"):
        words["run"] = sb.simulate(example("spinning_top"), (0, 0.01))
    path = tmp_path / str(words.pop("path"))
    with pytest.raises(sb.UsageError) as caught:
        sb.save_report(eqs, path, **words)  # type: ignore[arg-type]
    assert [problem.code for problem in caught.value.problems] == [code]
    assert not path.exists()


def test_folder_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(sb.EnvironmentFault, match=r"report\.unwritable"):
        sb.save_report(example("slider_crank"), tmp_path / "none" / "x.html", sections=["parameters"])


@pytest.mark.parametrize("suffix", [".html", ".tex", ".md", ".ipynb"])
def test_mechanisms_without_speeds(suffix: str, tmp_path: Path) -> None:
    parts = [sb.Body("B", mass=1), sb.Prismatic("P", "ground", "B", coordinate="x", motion="sin(t)")]
    for name, elements in (("driven", parts), ("nothing", [])):
        eqs = sb.form_equations(sb.Model(name, elements))
        text = write(eqs, tmp_path / f"{name}{suffix}", run=sb.simulate(eqs, 0.1) if elements else None)
        assert "There are no speeds" in text
        assert "Equations of motion" in text


def test_odd_names_of_files(tmp_path: Path) -> None:
    eqs = example("slider_crank")
    markdown = write(eqs, tmp_path / "my crank (50%).md", sections=["mechanism"])
    (link,) = re.findall(r"!\[[^]]*\]\(([^ )]*)\)", markdown)
    assert (tmp_path / unquote(link)).is_file()
    tex = write(eqs, tmp_path / "crank_50%#1.tex", sections=["mechanism"])
    (picture,) = re.findall(r"\\includegraphics\[[^]]*\]\{([^}]*)\}", tex)
    assert not set(picture) & set("%#")
    assert (tmp_path / picture).is_file()


@pytest.mark.parametrize("suffix", [".html", ".tex", ".md"])
def test_modes_that_are_zero_and_inputs_that_are(suffix: str, tmp_path: Path) -> None:
    body, rail = sb.Body("B", mass=1), sb.Prismatic("P", "ground", "B", force=sb.Drive(applied="F"))
    eqs = sb.form_equations(sb.Model("driven", [body, rail], inputs=["F"]))
    text = write(eqs, tmp_path / f"x{suffix}", sections=["equilibrium"])
    assert "inputs without a value are set to 0" in text
    assert not re.search(r"\b(nan|inf)\b", text)


def test_no_equilibrium_of_a_hundred_speeds_and_more(tmp_path: Path) -> None:
    ends = {"P": sb.Frame(at=(-0.5, 0, 0)), "Q": sb.Frame(at=(0.5, 0, 0))}
    parts: list[sb.Body | sb.Revolute] = []
    for k in range(101):
        start = f"B{k - 1}.Q" if k else "ground"
        parts += [
            sb.Body(f"B{k}", mass=1, inertia=(0, 0, 1), frames=ends),
            sb.Revolute(f"J{k}", start, f"B{k}.P"),
        ]
    eqs = sb.form_equations(sb.Model("chain", parts, (0, -9.81, 0)))
    assert "there are 101 speeds" in write(eqs, tmp_path / "x.html", sections=["equilibrium"])


@pytest.mark.parametrize(
    ("suffix", "head"),
    [("html", "<title>{{ title }}</title>"), ("tex", r"\section*{{{ title }}}"), ("md", "# Mine: {{title}}")],
)
def test_a_template_is_filled(suffix: str, head: str, tmp_path: Path) -> None:
    eqs = example("spring_mass_damper")
    frame = tmp_path / "frame.txt"
    frame.write_text(
        f"first {head}\n{{{{ equations }}}} between {{{{motion}}}}{{{{ parts }}}} last", encoding="utf-8"
    )
    text = write(eqs, tmp_path / f"x.{suffix}", title="A & B", template=frame)
    plain = write(eqs, tmp_path / f"y.{suffix}", title="A & B")
    first, last = text.index("first"), text.rindex("last")
    between = text.index(" between ")
    assert first < text.index("B", first) < between < last and "{{ " not in text
    shown = text[between + len(" between ") : last].strip()
    assert shown and shown in plain


@pytest.mark.parametrize(
    ("content", "code"),
    [("{{ bodi }}", "report.template_name"), ("nothing", "report.template_empty"), (None, "file.missing")],
)
def test_templates_that_cannot_be_filled(content: str | None, code: str, tmp_path: Path) -> None:
    frame = tmp_path / "frame.html"
    if content is not None:
        frame.write_text(content, encoding="utf-8")
    with pytest.raises(sb.SymbodyError) as caught:
        sb.save_report(
            example("spring_mass_damper"), tmp_path / "x.html", template=frame, sections=["parameters"]
        )
    assert [problem.code for problem in caught.value.problems] == [code]
    assert not (tmp_path / "x.html").exists()


def test_a_section_motion_needs_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from symbody.cli import run

    model = str(EXAMPLES / "spring_mass_damper" / "spring_mass_damper.toml")
    out = ["-o", str(tmp_path / "x.html"), "--section", "motion"]
    assert run(["report", model, *out]) != 0
    assert "--end" in capsys.readouterr().err
    assert run(["report", model, *out, "--end", "1"]) == 0
    assert "Coordinates over time" in (tmp_path / "x.html").read_text(encoding="utf-8")


def test_graphs_with_long_names_are_outlines(tmp_path: Path) -> None:
    ends = {"P": sb.Frame(at=(-0.5, 0, 0)), "Q": sb.Frame(at=(0.5, 0, 0))}
    names = [f"a_body_with_a_long_name_{k}" for k in range(4)]
    parts: list[sb.Body | sb.Revolute] = [
        sb.Body(name, mass=1, inertia=(0, 0, 1), frames=ends) for name in names
    ]
    for k, (start, end) in enumerate(zip(["ground", *names[:-1]], names, strict=True)):
        parts.append(sb.Revolute(f"joint_{k}", f"{start}.Q" if k else start, f"{end}.P"))
    parts.append(sb.Revolute("closing", "ground.R", f"{names[-1]}.Q"))
    eqs = sb.form_equations(sb.Model("loop", parts, ground={"R": sb.Frame(at=(2, 0, 0))}))
    sb.save_report(eqs, tmp_path / "x.md", sections=["graph"])
    (picture,) = (tmp_path / "x_pictures").iterdir()
    width, height = re.search(
        r'viewBox="0 0 ([\d.]+) ([\d.]+)"', picture.read_text(encoding="utf-8")
    ).groups()  # type: ignore[union-attr]
    assert float(height) > 5 * 20  # a row for each body and the ground
    assert float(width) < 504  # narrower than beside each other


def test_vectors_are_named_before_they_are_printed(tmp_path: Path) -> None:
    eqs, chosen = example("slider_crank"), ["parts", "dynamics"]
    tex = write(eqs, tmp_path / "x.tex", sections=chosen)
    assert r"$\boldsymbol{u}$ = ($\dot{\theta}$, $\dot{\beta}$, $\dot{s}$)" in tex
    assert r"\dot{\boldsymbol{u}} = \boldsymbol{F}" in tex and tex.index("speeds") < tex.index("bmatrix")
    assert r"($\frac{1}{2} \, L_{1}$, $0$, $0$)" in write(eqs, tmp_path / "x.md", sections=chosen)
    page = write(eqs, tmp_path / "x.html", sections=chosen)
    assert "with the speeds" in page and '<th scope="col"></th>' not in page
    assert ">turned about<" not in page  # nothing is turned
