"""Pages of the reference that follow from the package: public names, entries of files, the command line."""

from __future__ import annotations

import inspect
import json
import re
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import typer.main
from sphinx.application import Sphinx

import symbody
from symbody import cli
from symbody.model.declarations.declaration import Declared

PACKAGE = Path(symbody.__file__).parent
HEADING = re.compile(r"^# (?P<title>.+)$")
NAME = re.compile(r"^from \.\w+ import (\w+) as (?P<name>\w+)$")


def public_names() -> dict[str, dict[str, list[str]]]:
    """Return the public names under the headings of the stub, and under what follows a colon in these."""
    names: dict[str, dict[str, list[str]]] = {}
    title, part = "", ""
    for line in (PACKAGE / "__init__.pyi").read_text(encoding="utf-8").splitlines():
        if heading := HEADING.match(line):
            title, _, part = heading["title"].partition(": ")
        elif name := NAME.match(line):
            names.setdefault(title, {}).setdefault(part, []).append(name["name"])
    return names


def first_sentence(name: str) -> str:
    """Return the first sentence of the docstring of a public name."""
    text = " ".join((inspect.getdoc(getattr(symbody, name)) or "").split("\n\n")[0].split())
    return text.partition(". ")[0].rstrip(".")


def is_class(name: str) -> bool:
    """Return whether a public name is a class, which has a page of its own."""
    return inspect.isclass(getattr(symbody, name))


def slug(title: str) -> str:
    """Return the name of the page of a heading."""
    return re.sub(r"\W+", "_", title.lower())


def group_page(title: str, parts: Mapping[str, list[str]]) -> str:
    """Return the page of a heading as reStructuredText: tables of its names, then its functions."""
    lines = [title, "=" * len(title), ""]
    for part, names in parts.items():
        heading = part.capitalize()
        lines += [heading, "-" * len(heading), ""] if part else []
        lines += [".. list-table::", "   :class: lines", ""]
        for name in names:
            role = "class" if is_class(name) else "func"
            lines += [f"   * - :py:{role}:`~symbody.{name}`", f"     - {first_sentence(name)}"]
        lines.append("")
    every = [name for names in parts.values() for name in names]
    lines += [".. toctree::", "   :hidden:", "", *(f"   {name}" for name in every if is_class(name)), ""]
    functions = [name for name in every if not is_class(name)]
    lines += ["Functions", "-" * len("Functions"), ""] if functions else []
    for name in functions:
        lines += [f".. autofunction:: symbody.{name}", ""]
    return "\n".join(lines)


def class_page(name: str) -> str:
    """Return the page of a class as reStructuredText."""
    return "\n".join([name, "=" * len(name), "", f".. autoclass:: symbody.{name}", "   :members:", ""])


def functions_table() -> str:
    """Return a table of all public functions, one line each, as Markdown."""
    lines = []
    for title, parts in public_names().items():
        functions = [name for names in parts.values() for name in names if not is_class(name)]
        if functions:
            lines += [f"**[{title}](names/{slug(title)}.rst)**", "", "```{list-table}", ":class: lines", ""]
            for name in functions:
                lines += [f"* - {{py:func}}`~symbody.{name}`", f"  - {first_sentence(name)}"]
            lines += ["```", ""]
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
    names = folder / "names"
    for title, parts in public_names().items():
        texts[names / f"{slug(title)}.rst"] = group_page(title, parts)
        for name in filter(is_class, (each for listed in parts.values() for each in listed)):
            texts[names / f"{name}.rst"] = class_page(name)
    texts[names / "functions.inc"] = functions_table()
    for old in {*names.glob("*.*")} - texts.keys():
        old.unlink()
    for file, text in texts.items():
        file.parent.mkdir(parents=True, exist_ok=True)
        if not file.exists() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")


def _keep_sentence(app: Sphinx, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Keep the first sentence of an attribute whole, which napoleon would cut at a colon."""
    if what in ("attribute", "property"):
        lines.insert(0, "")


def _skip_method(app: Sphinx, what: str, name: str, obj: object, skip: bool, options: object) -> bool | None:
    """Leave out the methods of elements: these are described by their arguments, and nobody calls them."""
    owner = sys.modules.get(getattr(obj, "__module__", ""))
    outer = getattr(owner, str(getattr(obj, "__qualname__", "")).partition(".")[0], None)
    if inspect.isfunction(obj) and inspect.isclass(outer) and issubclass(outer, Declared):
        return True
    return None


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the pages with Sphinx."""
    app.connect("builder-inited", write_pages)
    app.connect("autodoc-process-docstring", _keep_sentence, priority=400)  # before napoleon, which has 500
    app.connect("autodoc-skip-member", _skip_method)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
