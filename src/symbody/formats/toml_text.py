"""Tables to TOML text, on top of an existing text whose comments and order are kept."""

from __future__ import annotations

import re
from collections.abc import Mapping
from decimal import Decimal
from typing import Any, Final, cast

import tomlkit
from tomlkit.items import AoT, Array, Float, InlineTable, Item, Table, Trivia

from symbody.expr.language.formula import Formula
from symbody.model.declarations.field import Node

# Keys whose value is a table under a header of its own; other tables stand in the line of their key.
_HEADED: Final = frozenset({"frames", "ground", "initial", "layout", "parameters"})
_INTEGER: Final = re.compile(r"0|-?[1-9][0-9]*")
_DECIMAL: Final = re.compile(r"-?(0|[1-9][0-9]*)\.[0-9]+")

Tree = Mapping[str, Node]


def write_toml(content: Tree, onto: str = "", before: Tree | None = None) -> str:
    """Return the TOML text of `content`.

    Parameters
    ----------
    onto : str
        Legal TOML text to be changed as little as possible.
    before : mapping, optional
        What `onto` says, in the form of `content`; what equals it is not touched.
    """
    document = tomlkit.parse(onto)
    _merge(document, before or {}, content)
    return tomlkit.dumps(document)


def write_layout(text: str, layout: Mapping[str, Any]) -> str:
    """Return a model file's text with another ``[layout]``; an empty one is left out.

    Raises TypeError or ValueError if the layout holds something that TOML cannot say.
    """
    document = tomlkit.parse(text)
    document.pop("layout", None)
    if layout:
        document["layout"] = tomlkit.item(dict(layout))
    return tomlkit.dumps(document)


def key_comments(text: str, table: str) -> dict[str, str]:
    """Return the comments that stand behind the keys of a top table, without their mark."""
    content = tomlkit.parse(text).get(table)
    items = dict(content.value.body) if isinstance(content, Table) else {}
    comments = {key.key: item.trivia.comment.lstrip("# ") for key, item in items.items() if key is not None}
    return {key: comment for key, comment in comments.items() if comment}


def _merge(table: Any, before: Tree, after: Tree) -> None:
    """Change a table of the document where `after` differs from `before`."""
    for key in before:
        if key not in after and key in table:
            del table[key]
    for key, node in after.items():
        old = before.get(key)
        if old == node:
            continue
        present = table.get(key)
        if isinstance(node, dict) and isinstance(old, dict) and isinstance(present, Table | InlineTable):
            _merge(present, old, node)
        elif isinstance(present, AoT) and isinstance(node, list) and isinstance(old, list):
            if not _merge_entries(present, old, node):
                table[key] = _item(key, node)
        else:
            table[key] = _item(key, node)


def _merge_entries(entries: AoT, before: list[Node], after: list[Node]) -> bool:
    """Change the tables of one kind of element; return False if that is beyond small changes."""
    olds = [cast("Tree", node) for node in before]
    news = [cast("Tree", node) for node in after]
    if len(olds) != len(entries):
        return False
    key = next((key for key in ("name", "prefix") if all(key in node for node in (*olds, *news))), "")
    if not key:
        return _merge_in_order(entries, olds, news)
    names = [node[key] for node in news]
    kept = [k for k, node in enumerate(olds) if node[key] in names]
    if [olds[k][key] for k in kept] != names[: len(kept)]:
        if len(olds) != len(news):
            return False
        kept = list(range(len(olds)))  # renamed in place
    for k in reversed(range(len(olds))):
        if k not in kept:
            del entries[k]
    for entry, k, node in zip(entries, kept, news, strict=False):
        _merge(entry, olds[k], node)
    for node in news[len(kept) :]:
        entries.append(_table(node))
    return True


def _merge_in_order(entries: AoT, olds: list[Tree], news: list[Tree]) -> bool:
    """Change tables without names, as those of shapes; return False if they are others than before."""
    if [old["type"] for old in olds] != [node["type"] for node in news]:
        return False
    for entry, old, node in zip(entries, olds, news, strict=True):
        _merge(entry, old, node)
    return True


def _item(key: str, node: Node) -> Item:
    if isinstance(node, dict):
        return _table(node, key not in _HEADED)
    if isinstance(node, list):
        if node and all(
            isinstance(entry, dict) and {"name", "type", "prefix"} & set(entry) for entry in node
        ):
            tables = tomlkit.aot()
            for entry in node:
                tables.append(_table(cast("Tree", entry)))
            return tables
        return _array(node)
    if isinstance(node, Formula):
        number = _number(node)
        return tomlkit.string(node.text) if number is None else number
    return tomlkit.item(node)


def _table(content: Tree, is_inline: bool = False) -> Table | InlineTable:
    # A table of tables only needs no header: [body.frames.tip] says it all.
    is_super = set(content) <= {"frames", "shape"}
    table = tomlkit.inline_table() if is_inline else tomlkit.table(is_super_table=is_super)
    for key, node in content.items():
        table.append(key, _item(key, node))
    return table


def _array(nodes: list[Node]) -> Array:
    """Return a list: of numbers if all are, else of texts, as readers expect lists to be."""
    array = tomlkit.array()
    numbers = [_number(node) for node in nodes if isinstance(node, Formula)]
    as_text = any(number is None for number in numbers)
    for node in nodes:
        plain = isinstance(node, Formula) and as_text
        array.append(tomlkit.string(node.text) if plain and isinstance(node, Formula) else _item("", node))
    return array


def _number(formula: Formula) -> Item | None:
    """Return a formula as TOML number if it is one and is read back with the same text."""
    if _INTEGER.fullmatch(formula.text):
        return tomlkit.item(int(formula.text))
    if _DECIMAL.fullmatch(formula.text) and str(Decimal(formula.text)) == formula.text:
        return Float(float(formula.text), Trivia(), formula.text)
    return None
