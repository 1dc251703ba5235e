"""Pictures that move on the site: where a page shows a picture of a mechanism, the site shows its motion.

The Markdown has a still picture, which any other reader of it shows. The pages of motions are written beside
the doctrees, once for a state of the package and the script, and copied to ``_moving`` of the site. Without
the built pages of the package (they need Node) the pictures stay still.
"""

from __future__ import annotations

import hashlib
import shutil
import sys
from collections.abc import Callable, Mapping
from functools import partial
from html import escape
from pathlib import Path
from typing import Any, Final

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.transforms import SphinxTransform
from sphinx.util.logging import getLogger

import symbody as sb

ROOT: Final = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

from docs import draw_mechanisms  # noqa: E402, beside the package, not in it

PACKAGE: Final = Path(sb.__file__).parent
FOLDER: Final = "_moving"
SLIDERS: Final = {"m2": (0.5, 3.0), "L2": (0.6, 2.0), "F": (-50.0, 50.0), "theta": (-1.0, 1.0)}
_BEFORE_IMAGES_ARE_COLLECTED: Final = 200


def _write_slider_crank(page: Path) -> None:
    model = sb.load_model(ROOT / "examples" / "slider_crank" / "slider_crank.toml")
    sb.animate(sb.form_equations(model), page, live=True, sliders=SLIDERS, title="Slider-crank")


def _write_mechanism(script: Path, page: Path) -> None:
    draw_mechanisms.write_motion_page(script, page)


# By page and picture in it: what is shown instead.
MOVING: Final[Mapping[tuple[str, str], str]] = {
    ("index", "live_page.png"): "slider_crank",
    ("live_pages", "live_page.png"): "slider_crank",
    ("how_to/show_motion", "live_page.png"): "slider_crank",
    **{(f"gallery/{path.stem}", f"{path.stem}.png"): path.stem for path in draw_mechanisms.MECHANISMS},
}
WRITERS: Final[Mapping[str, Callable[[Path], None]]] = {
    "slider_crank": _write_slider_crank,
    **{path.stem: partial(_write_mechanism, path) for path in draw_mechanisms.MECHANISMS},
}


def can_move() -> bool:
    """Return whether the pages that show motions are built."""
    return all((PACKAGE / "visual" / "pages" / name).is_file() for name in ("player.html", "live.html"))


class _MovingPictures(SphinxTransform):
    """Replaces pictures by frames with the pages of the motions."""

    default_priority = _BEFORE_IMAGES_ARE_COLLECTED

    def apply(self, **kwargs: Any) -> None:
        if not can_move():
            return
        for image in list(self.document.findall(nodes.image)):
            name = MOVING.get((self.env.docname, image["uri"].rpartition("/")[2]))
            if name is not None:
                up = "../" * self.env.docname.count("/")
                title = escape(image.get("alt", name), quote=True)
                page = f"{up}{FOLDER}/{name}.html"
                frame = (
                    f'<iframe class="moving" src="{page}" title="{title}" loading="lazy"></iframe>'
                    f'<p class="moving-link"><a href="{page}">Open in its own window</a></p>'
                )
                image.parent.replace_self(nodes.raw("", frame, format="html"))


def _key() -> bytes:
    """Return a digest of all that pages of motions are made of, scripts apart."""
    digest = hashlib.sha256(Path(__file__).read_bytes())
    for path in sorted([*PACKAGE.rglob("*.py"), *(PACKAGE / "visual" / "pages").glob("*")]):
        digest.update(path.read_bytes())
    return digest.digest()


def write_pages(app: Sphinx, exception: Exception | None) -> None:
    """Write the pages of motions that are not there yet, and copy all to the site."""
    if exception is not None or app.builder.format != "html" or not can_move():
        return
    store, target = Path(app.doctreedir) / FOLDER, Path(app.outdir) / FOLDER
    for folder in (store, target):
        folder.mkdir(parents=True, exist_ok=True)
    scripts, key = {path.stem: path for path in draw_mechanisms.MECHANISMS}, _key()
    for name, write in WRITERS.items():
        text = scripts[name].read_bytes() if name in scripts else b""
        page = store / f"{name}-{hashlib.sha256(key + text).hexdigest()[:16]}.html"
        if not page.is_file():
            getLogger(__name__).info("motion of %s", name)
            for old in store.glob(f"{name}-*.html"):
                old.unlink()
            unfinished = store / "unfinished.html"
            write(unfinished)
            unfinished.replace(page)
        shutil.copyfile(page, target / f"{name}.html")


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the extension."""
    app.add_transform(_MovingPictures)
    app.connect("build-finished", write_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
