"""The key of stored equations changes with every folder whose code forms them."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import symbody
import symbody as sb
from symbody.equations import cache_key
from tests.problems.mechanisms import model_of

PACKAGE = Path(symbody.__file__).parent
ROOMS = cache_key._ROOMS


# Files that decide no formula: words of messages, locks, where results lie, when garbage is collected.
WITHOUT_EFFECT = {"collection.py", "errors.py", "notebook.py", "single_flight.py", "storage.py"}


def imported_places(path: Path) -> set[str]:
    """The folders and files of the package that a file imports from."""
    modules: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            modules.add(node.module)
        elif isinstance(node, ast.Import):
            modules.update(alias.name for alias in node.names)
    parts = [module.split(".") for module in modules if module.startswith("symbody.")]
    return {name if (PACKAGE / name).is_dir() else f"{name}.py" for _, name, *_ in parts}


def test_everything_that_forms_equations_is_in_the_key() -> None:
    imported = set[str]()
    for room in ROOMS:
        files = sorted((PACKAGE / room).rglob("*.py"))
        assert files, f"there is no folder {room}"
        imported.update(*map(imported_places, files))
    assert imported - WITHOUT_EFFECT <= {*ROOMS, *cache_key._FILES}
    assert {"tolerances.py", "arguments.py"} <= imported  # as long as they are, the key needs them


def test_a_time_limit_holds_for_the_call_that_has_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Equations that an earlier process formed are formed on first use: from a property came what only the call
    # with the limit may raise, and came again each time.
    monkeypatch.setenv("SYMBODY_CACHE", str(tmp_path))
    tmp_path.chmod(0o700)
    model = model_of("four_bar")
    with pytest.raises(sb.TimeLimitError):
        sb.form_equations(model, time_limit=1e-9)
    before = sb.form_equations(model)
    cache_key.store_notes(before.identity, before.notes)
    later = sb.form_equations(model, time_limit=1e-9)
    assert later.mass_matrix == before.mass_matrix
    with pytest.raises(sb.TimeLimitError):  # the limit of compile covers forming
        sb.compile(sb.form_equations(model), "udot", time_limit=1e-9)
