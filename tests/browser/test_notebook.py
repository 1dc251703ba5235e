"""A notebook with equations, a plot and an animation: executed, exported to HTML, opened without a network."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.browser.conftest import Surfer, wait_until
from tests.browser.test_player import changed, pixels

EXAMPLES = Path(__file__).parents[2] / "examples"
CELLS = (
    f"import symbody as sb\nmodel = sb.load_model({str(EXAMPLES / 'four_bar' / 'four_bar.toml')!r})\n"
    "eqs = sb.form_equations(model)\neqs",
    "run = sb.simulate(eqs, 1.0)\nsb.plot(run, 'phi')",
    "sb.animate(run, traces=['Coupler.P'])",
)


def exported(folder: Path) -> Path:
    """The executed notebook as a page; a live view among its cells is left out of it."""
    nbformat, nbclient, nbconvert = (
        pytest.importorskip(name) for name in ("nbformat", "nbclient", "nbconvert")
    )
    pytest.importorskip("ipykernel")
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in CELLS])
    nbclient.NotebookClient(
        notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(folder)}}
    ).execute()
    text, _ = nbconvert.HTMLExporter().from_notebook_node(notebook)
    path = folder / "notebook.html"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.exhaustive
@pytest.mark.filterwarnings("ignore")  # of other packages, in a kernel of their own
def test_an_exported_notebook_works_without_a_network(surfer: Surfer) -> None:
    path = exported(surfer.folder)
    context = surfer.browser.new_context(viewport={"width": 1000, "height": 900}, offline=True)
    surfer.contexts.append(context)
    page: Any = context.new_page()
    page.goto(path.as_uri(), wait_until="domcontentloaded")
    assert page.locator("math").count() > 0  # the equations, which browsers draw by themselves
    image = page.locator(".jp-OutputArea-output img, .jp-OutputArea-output svg").first
    assert image.bounding_box()["width"] > 200
    page.locator("iframe").scroll_into_view_if_needed()  # what is out of sight is not drawn
    frame = page.locator("iframe").element_handle().content_frame()
    frame.wait_for_selector("canvas")
    wait_until(frame, "window.symbodyPlayer !== undefined")
    frame.evaluate("symbodyPlayer.setPlaying(false)")
    assert changed(pixels(frame, 0.1), pixels(frame, 0.3)) > 200
