"""Documents: opened, saved, recovered. The page holds what is edited; the files are the server's."""

from __future__ import annotations

import os
import secrets
from collections.abc import Mapping
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from threading import Lock
from typing import Any, Final

from symbody.builder.catalog import catalog
from symbody.builder.copies import copy_files
from symbody.builder.model_text import Opened, data_from_text, text_from_data
from symbody.builder.page_problems import page_notes
from symbody.builder.paths import contained_path, with_ending
from symbody.builder.refusal import refusal
from symbody.builder.requests import OpenRequest, SaveRequest
from symbody.builder.settings import BuilderSettings
from symbody.builder.user_state import UserState
from symbody.builder.wires import model_wires
from symbody.errors import FormatError, Problem, SymbodyError
from symbody.formats.model_files import load_model
from symbody.formats.native import to_data
from symbody.formats.reading import MAX_BYTES
from symbody.formats.urdf.building.loading import load_urdf
from symbody.formats.writing import write_text
from symbody.model.model import Model

Answer = dict[str, Any]

_TOML: Final = (".toml",)
_URDF: Final = (".urdf", ".xml")
_MOST_ENTRIES: Final = 2000
_MOST_DOCUMENTS: Final = 200
_EMPTY: Final = '# A mechanism\n\nname = "untitled"\ngravity = ["0", "-9.81", "0"]\n'


@dataclass(frozen=True, slots=True)
class Document:
    """What is open in a page.

    Attributes
    ----------
    path : str or None
        Its file; None before it is saved for the first time.
    name : str
        What the page calls it.
    mark : str or None
        Fingerprint of its file as it was opened or saved here.
    folder : str
        Where the files that it names begin, such as parts and meshes; "" where there are none.
    """

    path: str | None
    name: str
    mark: str | None = None
    folder: str = ""


class Documents:
    """All documents of a run, by identifier."""

    def __init__(self, settings: BuilderSettings) -> None:
        self._settings = settings
        self._user = UserState(settings.state)
        self._open: dict[str, Document] = {}
        self._lock = Lock()
        self._writing = Lock()

    def new(self) -> Answer:
        """Return an empty document."""
        return self._answer(Document(None, "untitled"), data_from_text(_EMPTY, "untitled"))

    def open(self, request: OpenRequest) -> Answer:
        """Return the document that a request names.

        Raises
        ------
        SymbodyError
            If it cannot be opened.
        """
        ways = {
            "path": self._open_path,
            "example": self._open_example,
            "draft": self._open_draft,
            "urdf": self._open_urdf,
        }
        given = [
            (word, getattr(request, word)) for word in (*ways, "text") if getattr(request, word) is not None
        ]
        if len(given) != 1:
            raise refusal(
                "builder.open", "open", f"{len(given)} documents were named to open", fix="name one"
            )
        word, value = given[0]
        if word == "text":
            name = Path(request.name).stem or "untitled"
            return self._answer(Document(None, name), data_from_text(value, request.name or "text"))
        return ways[word](value)

    def _open_path(self, path: str) -> Answer:
        real = contained_path(path, self._settings.roots)
        if real.suffix.lower() in _URDF:
            return self._open_urdf(path)
        with_ending(real, _TOML)
        content = read_bytes(real)
        opened = data_from_text(_decode(content, str(real)), real.name, os.path.dirname(real))
        self._remember(str(real))
        document = Document(str(real), real.stem, folder=os.path.dirname(real))
        return self._answer(document, opened, fingerprint(content))

    def _open_urdf(self, path: str) -> Answer:
        real = with_ending(contained_path(path, self._settings.roots), _URDF)
        return self._answer(Document(None, real.stem), _from_model(load_urdf(real)))

    def _open_example(self, name: str) -> Answer:
        path = self._example_path(name)
        return self._answer(Document(None, path.stem, folder=str(path.parent)), read_example(path))

    def _example_path(self, name: str) -> Path:
        for entry in catalog(self._settings.examples):
            if entry.name == name:
                return entry.path
        raise refusal("builder.unknown_example", name[:80], "there is no such example", fix="choose one")

    def _open_draft(self, draft: str) -> Answer:
        entry = self._user.draft(draft)
        path = entry.get("path") if isinstance(entry.get("path"), str) else None
        mark = entry.get("fingerprint") if isinstance(entry.get("fingerprint"), str) else None
        if path is not None:
            contained_path(path, self._settings.roots)
        opened = Opened(entry["data"], None, [])
        document = Document(path, str(entry.get("name")), folder=self._draft_folder(entry, path))
        return self._answer(document, opened, mark, draft)

    def _draft_folder(self, entry: Mapping[str, Any], path: str | None) -> str:
        """Return the folder of a draft: that of its file, or of the example that it was."""
        folder = Path(str(entry.get("folder") or ""))
        is_example = folder.is_relative_to(self._settings.examples) and folder.is_dir()
        return os.path.dirname(path) if path is not None else str(folder) if is_example else ""

    def _answer(
        self, document: Document, opened: Opened, mark: str | None = None, name: str | None = None
    ) -> Answer:
        identifier = name or secrets.token_hex(16)
        with self._lock:
            self._open[identifier] = replace(document, mark=mark)
            while len(self._open) > _MOST_DOCUMENTS:
                del self._open[next(iter(self._open))]
        return {
            "document": identifier,
            "path": document.path,
            "name": document.name,
            "data": opened.data,
            "fingerprint": mark,
            "problems": opened.problems,
            "comments": dict(opened.comments),
            "wires": model_wires(opened.data),
        }

    def save(self, request: SaveRequest) -> Answer:
        """Write a document to a file; unchanged data leave every byte as it is.

        Raises
        ------
        UsageError
            If the file is not the one that was opened, unless `overwrite`.
        FormatError
            If it cannot be written.
        """
        with self._writing:  # of pages that save at the same time the second finds what the first wrote
            return self._save(request)

    def _save(self, request: SaveRequest) -> Answer:
        document = self._document(request.document)
        real = with_ending(contained_path(request.path, self._settings.roots), _TOML)
        old = read_bytes(real) if real.exists() else None
        mark = None if old is None else fingerprint(old)
        is_same = mark == request.fingerprint and document.path in (None, str(real), request.path)
        if not request.overwrite and not is_same and old is not None:
            raise refusal(
                "builder.changed_outside",
                str(real),
                "the file has changed since it was opened",
                "another program changed or created it",
                "save under another name, open the file again, or overwrite it",
            )
        base = "" if old is None else _base(old, request.overwrite)
        content = text_from_data(request.data, base, os.path.dirname(real)).encode("utf-8")
        if document.folder:
            copy_files(request.data, document.folder, os.path.dirname(real))
        if content != old:
            write_text(real, content.decode("utf-8"))
        with self._lock:
            mark, folder = fingerprint(content), os.path.dirname(real)
            self._open[request.document] = Document(str(real), real.stem, mark, folder)
        self._user.drop_draft(request.document)
        self._remember(str(real))
        return {"path": str(real), "fingerprint": fingerprint(content)}

    def save_draft(self, identifier: str, data: dict[str, Any]) -> Answer:
        """Store what is edited, so that no crash costs it."""
        document = self._document(identifier)
        entry = {
            "path": document.path,
            "name": document.name,
            "fingerprint": document.mark,
            "folder": document.folder,
        }
        self._user.save_draft(identifier, entry, data)
        return {}

    def has_changed(self, identifier: str, mark: str | None) -> Answer:
        """Return whether the file of a document has another content than the one with a fingerprint."""
        path = self._document(identifier).path
        if path is None:
            return {"changed": False}
        try:
            return {"changed": fingerprint(read_bytes(contained_path(path, self._settings.roots))) != mark}
        except SymbodyError:  # it was moved or deleted
            return {"changed": True}

    def folder_of(self, identifier: str) -> str:
        """Return the folder from which paths of parts, tables and meshes begin; "" if there is none."""
        with self._lock:
            document = self._open.get(identifier)
        return "" if document is None else document.folder

    def recent(self) -> Answer:
        """Return the files that were used last."""
        return {"files": self._user.recent()}

    def recovery(self) -> Answer:
        """Return what was edited and never saved."""
        return {"drafts": self._user.drafts()}

    def examples(self) -> Answer:
        """Return the examples with a title and a sentence each."""
        return {"examples": [entry.describe() for entry in catalog(self._settings.examples)]}

    def folder(self, path: str) -> Answer:
        """Return the folders and model files in a folder inside the roots."""
        real = contained_path(path or str(self._settings.roots[-1]), self._settings.roots)
        try:
            with os.scandir(real) as entries:
                listed = [entry for entry in map(_folder_entry, entries) if entry][:_MOST_ENTRIES]
        except OSError as error:
            raise FormatError(
                Problem("builder.folder", str(real), f"the folder cannot be read: {error.strerror}",
                        fix="choose another one")
            ) from None  # fmt: skip
        listed.sort(key=lambda entry: (entry["kind"] != "folder", entry["name"].lower()))
        is_inside = any(real.parent.is_relative_to(root) for root in self._settings.roots)
        return {"path": str(real), "parent": str(real.parent) if is_inside else None, "entries": listed}

    def _document(self, identifier: str) -> Document:
        with self._lock:
            document = self._open.get(identifier)
        if document is None:
            raise refusal(
                "builder.unknown_document",
                identifier[:40],
                "the document is not open here",
                "the server was restarted",
                "save it under its name as a new document",
            )
        return document

    def adopt(self, identifier: str, path: str | None, name: str, mark: str | None = None) -> Answer:
        """Take on a document of a page that an earlier run of the server opened, with its fingerprint.

        Raises
        ------
        UsageError
            If its path lies outside the roots.
        """
        UserState.check_identifier(identifier)
        real = None if path is None else str(contained_path(path, self._settings.roots))
        with self._lock:
            folder = "" if real is None else os.path.dirname(real)
            self._open.setdefault(identifier, Document(real, name, mark, folder))
        return {}

    def _remember(self, path: str) -> None:
        try:
            self._user.remember(path)
        except FormatError:  # a folder that cannot be written to: there is no list
            pass


def fingerprint(content: bytes) -> str:
    """Return what tells one content of a file from all others."""
    return sha256(content).hexdigest()


def read_bytes(path: Path) -> bytes:
    """Return the content of a regular file.

    Raises
    ------
    FormatError
        If there is none, or it is too large.
    """
    try:
        if not path.is_file():
            raise FormatError(
                Problem("builder.no_file", str(path), "there is no such file", fix="check the path")
            )
        if path.stat().st_size > MAX_BYTES:
            raise FormatError(
                Problem("builder.large_file", str(path), f"the file has more than {MAX_BYTES} bytes",
                        fix="choose a model file")
            )  # fmt: skip
        return path.read_bytes()
    except OSError as error:
        raise FormatError(
            Problem("builder.unreadable", str(path), f"the file cannot be read: {error.strerror}",
                    fix="check its permissions")
        ) from None  # fmt: skip


def _decode(content: bytes, where: str) -> str:
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise FormatError(
            Problem("builder.not_text", f"{where}:{line}", "the file is not UTF-8 text",
                    fix="save it as UTF-8 in a text editor")
        ) from None  # fmt: skip


def _base(old: bytes, overwrite: bool) -> str:
    """Return the text whose comments are kept; a file that is overwritten may be anything."""
    return old.decode("utf-8", "replace" if overwrite else "strict") if b"\0" not in old else ""


def _from_model(model: Model) -> Opened:
    data = to_data(model)
    return Opened(data, model, page_notes(model.notes, data))


def read_example(path: Path) -> Opened:
    """Return the data of an example, with the folder of its parts."""
    if path.suffix == ".urdf":
        return _from_model(load_model(path))
    return data_from_text(path.read_text(encoding="utf-8"), path.name, str(path.parent))


def _folder_entry(entry: os.DirEntry[str]) -> dict[str, str] | None:
    if entry.name.startswith("."):
        return None
    try:
        kind = "folder" if entry.is_dir() else _kind(entry.name) if entry.is_file() else ""
    except OSError:
        return None
    return {"name": entry.name, "kind": kind} if kind else None


def _kind(name: str) -> str:
    return {".toml": "model", ".urdf": "urdf"}.get(os.path.splitext(name)[1].lower(), "")
