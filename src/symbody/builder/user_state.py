"""Drafts and recent files in a folder of the user's own; what fails here costs nobody a model."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

from symbody.builder.refusal import refusal
from symbody.formats.writing import write_text

_ID: Final = re.compile(r"[0-9a-f]{32}")
_MOST_DRAFTS: Final = 20
_MOST_RECENT: Final = 12


@dataclass(frozen=True, slots=True)
class UserState:
    """A folder with ``recent.json`` and ``drafts/ID.json``."""

    folder: Path

    def recent(self) -> list[dict[str, str]]:
        """Return the files that were opened or saved last, the newest first; only those that are there."""
        listed = _read_json(self.folder / "recent.json")
        entries = listed if isinstance(listed, list) else []
        return [entry for entry in entries if _is_entry(entry) and os.path.isfile(entry["path"])]

    def remember(self, path: str) -> None:
        """Put a file first among the recent ones."""
        entry = {"path": path, "name": Path(path).name, "when": _now()}
        others = [each for each in self.recent() if each["path"] != path]
        self._write(self.folder / "recent.json", [entry, *others][:_MOST_RECENT])

    def save_draft(self, document: str, entry: Mapping[str, str | None], data: dict[str, Any]) -> None:
        """Store the state of a document until it is saved; `entry` is what else `Document` holds of it."""
        self._write(self._draft(document), {"id": document, **entry, "when": _now(), "data": data})

    def drop_draft(self, document: str) -> None:
        """Forget the draft of a document that was saved."""
        with suppress(OSError):
            self._draft(document).unlink(missing_ok=True)

    def drafts(self) -> list[dict[str, Any]]:
        """Return the drafts without their data, the newest first."""
        entries = [_read_json(path) for path in self._draft_files()]
        drafts = [
            {key: entry.get(key) for key in ("id", "path", "name", "when")}
            for entry in entries
            if isinstance(entry, dict) and isinstance(entry.get("data"), dict)
        ]
        drafts.sort(key=lambda entry: str(entry["when"]), reverse=True)
        return drafts

    def draft(self, document: str) -> dict[str, Any]:
        """Return a draft with its data.

        Raises
        ------
        UsageError
            If there is none.
        """
        entry = _read_json(self._draft(document))
        if not isinstance(entry, dict) or not isinstance(entry.get("data"), dict):
            raise refusal("builder.unknown_draft", document, "there is no such draft", fix="open the file")
        return entry

    @staticmethod
    def check_identifier(document: str) -> None:
        """Refuse what is not an identifier of a document, so that none becomes a path.

        Raises
        ------
        UsageError
            If it is none.
        """
        if not _ID.fullmatch(document):
            raise refusal(
                "builder.unknown_draft", document[:40], "there is no such draft", fix="open the file"
            )

    def _draft(self, document: str) -> Path:
        self.check_identifier(document)
        return self.folder / "drafts" / f"{document}.json"

    def _draft_files(self) -> list[Path]:
        with suppress(OSError):
            return [path for path in (self.folder / "drafts").glob("*.json") if _ID.fullmatch(path.stem)]
        return []

    def _write(self, path: Path, content: Any) -> None:
        """Write a file that nobody else can read, in one step.

        Raises
        ------
        FormatError
            If it cannot be written.
        """
        with suppress(OSError):  # the writer says why
            path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        write_text(path, json.dumps(content), keep=False)
        if path.parent.name == "drafts":
            for old in sorted(self._draft_files(), key=_age)[:-_MOST_DRAFTS]:
                with suppress(OSError):
                    old.unlink()


def _age(path: Path) -> float:
    with suppress(OSError):
        return path.stat().st_mtime
    return 0.0


def _read_json(path: Path) -> Any:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None


def _is_entry(entry: Any) -> bool:
    return isinstance(entry, dict) and all(
        isinstance(entry.get(key), str) for key in ("path", "name", "when")
    )


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
