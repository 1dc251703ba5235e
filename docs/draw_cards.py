"""Draw the cards of the editor: `python docs/draw_cards.py` renews the picture of each example and mechanism.

The pictures are src/symbody/builder/cards/NAME.webp and NAME_dark.webp: each mechanism at its start.
Names as arguments draw these alone.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Final

from PIL import Image

from symbody.builder.catalog import CARDS, catalog
from symbody.builder.documents import read_example
from symbody.builder.tasks.mechanisms import mechanism_of, solver_of
from symbody.builder.tasks.placement import draw_at
from symbody.builder.tasks.reading import complete_model
from symbody.formats.model_files import examples_folder
from symbody.visual.film.pictures import write_still
from symbody.visual.film.studio import Look

SIZE: Final = (464, 216)  # of a card, at two pixels a point
_QUALITY: Final = 70  # of the compression: all of them stay below 600 kB


def draw_card(path: Path, dark: bool) -> Image.Image:
    """Return the picture of a model file."""
    data, folder = read_example(path).data, str(path.parent)
    model = complete_model(data, folder)
    eqs = mechanism_of(data, folder, lambda: model).with_values(model)
    scene, motion = draw_at(eqs, solver_of(data, folder, model).positions({}, {}))
    with tempfile.TemporaryDirectory() as place:
        drawn = Path(place) / "card.png"
        write_still(scene, motion, drawn, Look(size=SIZE, dark=dark))
        with Image.open(drawn) as picture:
            return picture.convert("RGB")


def main(names: list[str]) -> None:
    """Draw the cards of these names, or of all."""
    for entry in catalog(examples_folder()):
        if names and entry.name not in names:
            continue
        for dark in (False, True):
            path = CARDS / f"{entry.name}{'_dark' if dark else ''}.webp"
            path.parent.mkdir(parents=True, exist_ok=True)
            draw_card(entry.path, dark).save(path, quality=_QUALITY, method=6)
            print(path.name, path.stat().st_size)


if __name__ == "__main__":
    main(sys.argv[1:])
