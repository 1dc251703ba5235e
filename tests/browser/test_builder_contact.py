"""A ball that falls on the ground and leaves it again, from an empty page."""

from __future__ import annotations

import numpy as np
import pytest

from .builder_plans import errors_of
from .builder_visits import Visit

HEIGHT, RADIUS, G = 1.0, 0.2, 9.81


def test_a_ball_dropped_on_the_ground_bounces_with_its_restitution(visit: Visit) -> None:
    builder = visit()
    page = builder.page
    builder.new()
    page.get_by_test_id("palette-ball").click()
    page.get_by_test_id("palette-contact").click()
    builder.wait_checked()
    (contact,) = builder.state("data.contact")
    assert contact["between"] == ["ground.floor", "Ball1"]
    assert contact["shapes"] == ["plane", {"sphere": "R1"}]
    law = page.get_by_role("radiogroup", name="Normal")
    law.get_by_role("radio", name="rigid").click()
    page.get_by_label("Restitution").fill("0.5")
    builder.wait_checked()
    assert errors_of(builder) == []
    assert builder.state("data.contact")[0]["normal"] == "rigid"
    # a gap is no constraint, so that nothing is redundant; the counts say what holds while it is closed
    counts = page.get_by_test_id("live")
    assert "0 constraints" in (counts.text_content() or "") and "1 unilateral" in (
        counts.text_content() or ""
    )
    assert "redundant" not in (counts.text_content() or "")
    field = page.get_by_label("Restitution")
    field.fill("2")
    builder.wait_checked()
    assert field.get_attribute("aria-invalid") == "true"
    assert page.locator(".properties").get_by_text("give a number from 0 to 1").count() == 1
    page.locator(".react-flow__pane").click(position={"x": 5, "y": 5})
    page.keyboard.press("Control+z")  # what was typed into one field is one step
    builder.wait_checked()
    assert "restitution" not in builder.state("data.contact")[0]
    assert errors_of(builder) == []
    page.keyboard.press("Control+Shift+z")
    builder.wait_checked()
    assert builder.state("data.contact")[0]["restitution"] == "2"
    page.keyboard.press("Control+z")
    page.get_by_test_id(f"badge-{contact['name']}").click()
    page.get_by_label("Restitution").fill("0.5")
    builder.wait_checked()
    builder.simulate()
    times, heights = (np.array(each) for each in builder.curve("Ball1_y"))
    fall = np.sqrt(2 * (HEIGHT - RADIUS) / G)
    after = (times > fall) & (times < 1.9 * fall)
    # half the speed is left, so a quarter of the height; the samples are near the top, not on it
    assert np.max(heights[after]) == pytest.approx(RADIUS + (HEIGHT - RADIUS) / 4, rel=1e-2)
    assert np.min(heights) > RADIUS - 1e-5 and heights[-1] == pytest.approx(RADIUS, abs=1e-5)
    assert page.get_by_text("Contacts", exact=True).count() >= 2  # of the palette, and of the curves
