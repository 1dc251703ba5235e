"""The notebook widget: the player of the page, with its time and its sliders shared with Python."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import anywidget
import traitlets

from symbody.analysis.state import State
from symbody.errors import SymbodyError
from symbody.visual.viewer.built_files import built_file
from symbody.visual.viewer.live import SliderMechanism
from symbody.visual.viewer.page import PageData


class MechanismWidget(anywidget.AnyWidget):
    """The player in a notebook.

    Parameters
    ----------
    data : PageData
        What a page is given.
    mechanism : SliderMechanism, optional
        What sliders move.
    """

    data = traitlets.Dict().tag(sync=True)
    time = traitlets.Float(0.0).tag(sync=True)
    playing = traitlets.Bool(False).tag(sync=True)
    pose = traitlets.Dict(allow_none=True, default_value=None).tag(sync=True)
    sliders = traitlets.List().tag(sync=True)
    slider_values = traitlets.Dict().tag(sync=True)
    height = traitlets.Int(520).tag(sync=True)
    message = traitlets.Unicode("").tag(sync=True)
    _mechanism: SliderMechanism | None = None
    _state: State | None = None

    def __init__(self, data: PageData, mechanism: SliderMechanism | None = None, **options: Any) -> None:
        sliders = () if mechanism is None else mechanism.sliders
        super().__init__(
            _esm=built_file("widget.js"),
            data=data,
            sliders=[asdict(slider) for slider in sliders],
            slider_values={slider.name: slider.value for slider in sliders},
            **options,
        )
        self._mechanism = mechanism  # from now on sliders move it
        self._state = None if mechanism is None else mechanism.first

    @property
    def state(self) -> State | None:
        """Where the sliders have moved the mechanism; None without sliders."""
        return self._state

    @traitlets.observe("slider_values")
    def _move(self, change: Mapping[str, Any]) -> None:
        """Assemble the mechanism anew; where that is impossible it stays, and `message` holds the reason."""
        mechanism, near = self._mechanism, self._state
        if mechanism is None or near is None:
            return
        try:
            old, new = change["old"], change["new"]
            moved = [name for name in new if new[name] != old.get(name)]
            state = mechanism.state(new, near, moved)
        except SymbodyError as error:
            self.message = str(error)
            return
        self.message, self._state = "", state
        if mechanism.parameters(state) != mechanism.parameters(near):  # shapes follow the parameters
            self.data = mechanism.data(state, self.data["title"], self.data["options"])
        self.pose = mechanism.pose(state)
