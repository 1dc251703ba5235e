"""Small pictures of mechanisms at their start, as cards show them."""

from __future__ import annotations

import base64
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from symbody.builder.task_failure import Report
from symbody.builder.tasks.mechanisms import mechanism_of, solver_of
from symbody.builder.tasks.placement import draw_at
from symbody.builder.tasks.reading import complete_model
from symbody.visual.film.pictures import write_still
from symbody.visual.film.studio import Look

SIZE: Final = (464, 216)  # of a card, at two pixels a point


def draw_card(payload: Mapping[str, Any], report: Report) -> dict[str, str]:
    """Return the picture of a model, as PNG in base 64."""
    data, folder = payload["data"], payload["folder"]
    model = complete_model(data, folder)
    eqs = mechanism_of(data, folder, lambda: model).with_values(model)
    scene, motion = draw_at(eqs, solver_of(data, folder, model).positions({}, {}))
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "card.png"
        write_still(scene, motion, path, Look(size=SIZE, dark=bool(payload["dark"])))
        return {"png": base64.b64encode(path.read_bytes()).decode("ascii")}
