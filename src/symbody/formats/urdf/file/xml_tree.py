"""XML as a tree with line numbers, without document types, entities or anything from outside."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final
from xml.parsers import expat

from symbody.errors import FormatError, Problem

MAX_DEPTH: Final = 64
MAX_NODES: Final = 200_000


@dataclass(frozen=True, slots=True)
class XmlNode:
    """An element.

    Attributes
    ----------
    line : int
        Where it begins, counted from 1.
    """

    tag: str
    attributes: Mapping[str, str]
    line: int
    children: list[XmlNode] = field(default_factory=list)

    def all(self, tag: str) -> list[XmlNode]:
        """Return the children with a tag."""
        return [child for child in self.children if child.tag == tag]

    def walk(self) -> Iterator[XmlNode]:
        """Return this element and everything in it."""
        waiting = [self]
        while waiting:
            node = waiting.pop()
            yield node
            waiting.extend(reversed(node.children))


def parse_xml(text: str, where: str) -> XmlNode:
    """Return the outermost element of an XML text; `where` is what messages call it.

    Raises
    ------
    FormatError
        If it is not XML, declares a document type or entities, or is nested or long beyond all use.
    """
    builder = _Builder(where)
    parser = expat.ParserCreate()
    parser.StartElementHandler = lambda tag, attributes: builder.start(
        tag, attributes, parser.CurrentLineNumber
    )
    parser.EndElementHandler = lambda tag: builder.end()
    parser.StartDoctypeDeclHandler = lambda *_: builder.refuse_doctype(parser.CurrentLineNumber)
    parser.EntityDeclHandler = lambda *_: builder.refuse_doctype(parser.CurrentLineNumber)
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        raise FormatError(_syntax(where, error)) from None
    return builder.root


class _Builder:
    """Takes what the parser finds; made for one text and dropped."""

    __slots__ = ("_count", "_open", "_where", "root")

    def __init__(self, where: str) -> None:
        self._where = where
        self._open: list[XmlNode] = []
        self._count = 0
        self.root = XmlNode("", {}, 1)

    def start(self, tag: str, attributes: Mapping[str, str], line: int) -> None:
        self._count += 1
        if len(self._open) >= MAX_DEPTH or self._count > MAX_NODES:
            deep = len(self._open) >= MAX_DEPTH
            limit = f"nested more than {MAX_DEPTH} deep" if deep else f"more than {MAX_NODES} elements"
            raise FormatError(
                Problem("file.too_complex", f"{self._where}:{line}", f"the file is too complex: {limit}",
                        "this is not a robot, or it was made by a program", "split it, or check the file")
            )  # fmt: skip
        node = XmlNode(tag, dict(attributes), line)
        if self._open:
            self._open[-1].children.append(node)
        else:
            self.root = node
        self._open.append(node)

    def end(self) -> None:
        self._open.pop()

    def refuse_doctype(self, line: int) -> None:
        raise FormatError(
            Problem("urdf.doctype", f"{self._where}:{line}", "the file declares a document type or entities",
                    "they can make a small file expand endlessly, or read other files; robots do not need "
                    "them",
                    "delete the declaration <!DOCTYPE ..>")
        )  # fmt: skip


def _syntax(where: str, error: expat.ExpatError) -> Problem:
    reason = expat.ErrorString(error.code)
    return Problem(
        "urdf.syntax",
        f"{where}:{error.lineno}",
        f"the file is not XML: {reason} at column {error.offset + 1}",
        "a tag is not closed, or a quote or bracket is missing, here or before",
        "correct the XML; if the file is a xacro template, run xacro on it first",
    )
