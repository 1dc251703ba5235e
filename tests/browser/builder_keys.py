"""What a user types in the builder who has no mouse: fields, rows of tables, choices."""

from __future__ import annotations

from .builder_page import BuilderPage


def type_frames(builder: BuilderPage, frames: dict[str, str]) -> None:
    """Give the selected body its frames, from its fields and back to the diagram."""
    for frame, place in frames.items():
        builder.keys("F4")
        builder.go_to("Add a frame")
        builder.keys("Enter", "F4")
        latest = list(builder.state("data.body.at(-1).frames"))[-1]
        if latest != frame:
            builder.type_into(f"Name of {latest}", frame)
            builder.keys("Enter")
        builder.type_into(f"{frame} at x", place)
        builder.keys("Escape")


def type_rows(builder: BuilderPage, button: str, rows: dict[str, str]) -> None:
    builder.keys("F4")
    for name, value in rows.items():
        builder.go_to(button)
        builder.keys("Enter")
        builder.page.wait_for_timeout(150)  # the focus goes to the new row
        if button == "Add an initial value":
            builder.keys("Shift+Tab")
        builder.keys("Control+a")
        builder.page.keyboard.type(name)
        builder.keys("Tab", "Control+a")
        builder.page.keyboard.type(value)
    builder.keys("Escape")


def choose(builder: BuilderPage, label: str, value: str) -> None:
    """Set a list by its letters."""
    builder.go_to(label)
    builder.page.keyboard.type(value)
    assert builder.page.evaluate("document.activeElement.value") == value
