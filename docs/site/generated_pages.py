"""Pages of the reference that follow from the package: public names, entries of files, the command line."""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import typer.main
from sphinx.application import Sphinx

import symbody
from symbody import cli

PACKAGE = Path(symbody.__file__).parent
HEADING = re.compile(r"^# (?P<title>.+)$")
NAME = re.compile(r"^from \.\w+ import (\w+) as (?P<name>\w+)$")


def public_names() -> dict[str, list[str]]:
    """Return the public names under the headings of the stub, which stand in the order of their use."""
    names: dict[str, list[str]] = {}
    title = ""
    for line in (PACKAGE / "__init__.pyi").read_text(encoding="utf-8").splitlines():
        if heading := HEADING.match(line):
            title = heading["title"]
        elif name := NAME.match(line):
            names.setdefault(title, []).append(name["name"])
    return names


def names_page(title: str, names: list[str]) -> str:
    """Return the page of some public names as reStructuredText."""
    lines = [title, "=" * len(title), ""]
    for name in names:
        kind = "class" if inspect.isclass(getattr(symbody, name)) else "function"
        members = ["   :members:"] if kind == "class" else []
        lines += [f".. auto{kind}:: symbody.{name}", *members, ""]
    return "\n".join(lines)


def file_page() -> str:
    """Return the page of the entries of model files as Markdown, from their schema."""
    schema = json.loads((PACKAGE / "formats" / "schema.json").read_text(encoding="utf-8"))
    entries = schema["$defs"]
    lines = ["# Entries of the model file", "", schema["description"], "", *_entry_table(schema)]
    sections = {
        name: kind for name, kind in schema["properties"].items() if name not in ("layout", "version")
    }
    listed: list[str] = []
    for section, kind in sections.items():
        used = [name for name in _references(kind) if name not in listed]
        listed += used
        for name in used:
            word = entries[name]["properties"].get("type", {}).get("const")
            title = f"`[[{section}]]` of type `{word}`" if word else f"`{section}`"
            lines += ["", f"## {title}", "", entries[name]["description"], "", *_entry_table(entries[name])]
    for name in entries:
        if name not in listed:
            title = name.removesuffix("Entry")
            lines += ["", f"## {title}", "", entries[name]["description"], "", *_entry_table(entries[name])]
    return "\n".join([*lines, ""])


def _references(kind: Mapping[str, Any]) -> list[str]:
    return sorted({each.rpartition("/")[2] for each in re.findall(r"#/\$defs/\w+", json.dumps(kind))})


def _entry_table(entry: Mapping[str, Any]) -> Iterator[str]:
    yield "| key | default | meaning |"
    yield "| --- | --- | --- |"
    for key, field in entry.get("properties", {}).items():
        if "const" in field:
            continue
        required = key in entry.get("required", ())
        default = "required" if required else _default(field.get("default"))
        meaning = str(field.get("description", "")).replace("|", "\\|")
        yield f"| `{key}` | {default} | {meaning} |"


def _default(value: object) -> str:
    return "" if value in (None, [], {}) else f"`{json.dumps(value)}`"


def command_page() -> str:
    """Return the page of the command line as Markdown."""
    group: Any = typer.main.get_command(cli.app)
    lines = ["# The command line", "", "`symbody COMMAND --help` prints the same in a terminal.", ""]
    for name, command in group.commands.items():
        if not command.hidden:
            lines += _command(name, command)
    return "\n".join(lines)


def _command(name: str, command: Any) -> Iterator[str]:
    arguments = [each for each in command.params if each.param_type_name == "argument"]
    options = [each for each in command.params if each.param_type_name == "option" and not each.hidden]
    words = " ".join(str(each.name).upper() for each in arguments)
    yield from (
        f"## {name}",
        "",
        f"    symbody {name} {words}".rstrip(),
        "",
        inspect.cleandoc(command.help or ""),
        "",
    )
    if options:
        yield from ("| option | meaning |", "| --- | --- |")
        for option in options:
            yield f"| `{'`, `'.join((*option.opts, *option.secondary_opts))}` | {_line(option.help or '')} |"
        yield ""


def _line(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


def write_pages(app: Sphinx) -> None:
    """Write the pages beside their neighbours where they changed."""
    folder = Path(app.srcdir) / "reference"
    texts = {folder / "model_file_entries.md": file_page(), folder / "command_line.md": command_page()}
    for title, names in public_names().items():
        file = folder / "names" / (re.sub(r"\W+", "_", title.lower()) + ".rst")
        texts[file] = names_page(title[0].upper() + title[1:], names)
    for file, text in texts.items():
        file.parent.mkdir(parents=True, exist_ok=True)
        if not file.exists() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")


def _keep_sentence(app: Sphinx, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Keep the first sentence of an attribute whole, which napoleon would cut at a colon."""
    if what in ("attribute", "property"):
        lines.insert(0, "")


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the pages with Sphinx."""
    app.connect("builder-inited", write_pages)
    app.connect("autodoc-process-docstring", _keep_sentence, priority=400)  # before napoleon, which has 500
    return {"parallel_read_safe": True, "parallel_write_safe": True}
