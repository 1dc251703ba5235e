"""Pictures for both colours of the site: where there is NAME_dark.svg, dark pages show it for NAME.svg.

Furo has classes that hide one of them. Lines and letters on white, as plots and sketches
are, need no second file: symbody.css inverts them.
"""

from __future__ import annotations

from pathlib import Path, PurePosixPath
from typing import Final

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.transforms import SphinxTransform

_BEFORE_IMAGES_ARE_COLLECTED: Final = 210


def dark_name(uri: str) -> str:
    """Return where the dark one of a picture would lie."""
    path = PurePosixPath(uri)
    return str(path.with_name(f"{path.stem}_dark{path.suffix}"))


class _DarkPictures(SphinxTransform):
    """Puts a picture for dark pages beside each that has one."""

    default_priority = _BEFORE_IMAGES_ARE_COLLECTED

    def apply(self, **kwargs: object) -> None:
        folder = Path(self.env.doc2path(self.env.docname)).parent
        for image in list(self.document.findall(nodes.image)):
            dark = dark_name(image["uri"])
            if (folder / dark).is_file():
                other = image.deepcopy()
                other["uri"] = dark
                image["classes"].append("only-light")
                other["classes"].append("only-dark")
                image.parent.insert(image.parent.index(image) + 1, other)


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the extension."""
    app.add_transform(_DarkPictures)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
