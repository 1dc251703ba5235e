"""The cards of the start: what is offered, in which order, and with which words."""

from __future__ import annotations

import numpy as np
from PIL import Image

from symbody.builder.catalog import CARDS, catalog, in_title_case
from symbody.formats.model_files import examples_folder


def test_the_catalogue_begins_with_the_simple_ones_and_has_no_text_of_files() -> None:
    entries = list(catalog(examples_folder()))
    names = [entry.name for entry in entries]
    assert names[:2] == ["spring_mass_damper", "slider_crank"] and "leg" not in names
    assert len(names) == len(set(names))
    gallery = [entry for entry in entries if entry.group != "examples"]
    assert len(gallery) == 49 and {"linkages/watt", "drives/oldham"} <= {entry.name for entry in gallery}
    for entry in entries:
        card = entry.describe()
        assert card["title"] and card["summary"], entry.name
        assert "version =" not in card["summary"] and "name =" not in card["summary"]


def test_titles_have_capitals() -> None:
    assert in_title_case("spring-mass-damper") == "Spring-Mass-Damper"
    assert in_title_case("rr_robot of a PID") == "RR Robot of a PID"
    assert in_title_case("Watt's linkage") == "Watt's Linkage"


def test_each_card_has_a_picture_for_light_and_dark_pages_and_no_picture_is_left_over() -> None:
    names = {f"{entry.name}{ending}.webp" for entry in catalog(examples_folder()) for ending in ("", "_dark")}
    assert names == {path.relative_to(CARDS).as_posix() for path in CARDS.rglob("*.*")}
    for path in CARDS.rglob("*.webp"):
        with Image.open(path) as picture:
            assert picture.size == (464, 216), path.name
            shades = np.asarray(picture.convert("L"), dtype=float)
        assert np.ptp(shades) > 60, path.name  # something is drawn
