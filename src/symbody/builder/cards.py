"""Small pictures of examples: drawn by a worker when they are first wanted, then kept as files."""

from __future__ import annotations

import base64
import json
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import Any, Final

import symbody
from symbody.builder.workers import NewestOnly

_FOLDER: Final = "cards"


class Cards:
    """Pictures by the model, the theme and the version that drew them."""

    def __init__(self, state: Path, drawing: NewestOnly, limit: float) -> None:
        self._folder = Path(state) / _FOLDER
        self._drawing = drawing
        self._limit = limit

    def picture(self, name: str, data: dict[str, Any], folder: str, dark: bool) -> dict[str, str]:
        """Return the picture of an example, as PNG in base 64.

        Raises
        ------
        UsageError, TaskFailure
            If it cannot be drawn, or not in time.
        """
        content = json.dumps([symbody.__version__, data, dark], sort_keys=True)
        path = self._folder / f"{sha256(content.encode()).hexdigest()[:32]}.png"
        with suppress(OSError):
            return {"png": base64.b64encode(path.read_bytes()).decode("ascii")}
        payload = {"data": data, "folder": folder, "dark": dark}
        drawn: dict[str, str] = self._drawing.run("card", payload, f"{name} {dark}", self._limit)
        with suppress(OSError):  # a folder that cannot be written to: it is drawn again
            self._folder.mkdir(parents=True, exist_ok=True)
            draft = path.with_suffix(".part")
            draft.write_bytes(base64.b64decode(drawn["png"]))
            draft.replace(path)
        return drawn
