"""The shape of the source: every rule that a script can check, each shown to catch its offence."""

from __future__ import annotations

import ast
import io
import re
import statistics
import tokenize
from collections.abc import Callable, Iterator
from functools import lru_cache
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[1] / "src" / "symbody"
FILES = sorted([*SOURCE.rglob("*.py"), *SOURCE.rglob("*.pyi")])

# A file is one thought, which its first line names. The aim for the median is 130; the limit keeps it from
# drifting away.
MAX_FILE, MAX_MEDIAN, MAX_FUNCTION = 600, 150, 60
DRAWERS = {"base", "common", "helpers", "misc", "utils"}
# Text never becomes code: these turn strings into it.
TEXT_TO_CODE = {"eval", "exec", "lambdify", "parse_expr", "sympify"}
# Packages of pyproject's extras: the only ones that may be imported where they are used.
EXTRAS = {"collada", "imageio_ffmpeg", "pandas", "trimesh", "xarray"}
# "file: class" of dataclasses that have to change after they are made; say why beside each.
MUTABLE_DATACLASSES = frozenset(
    {"dynaflexpro/exports.py: ModelEquations"}  # SetBaumgarte changes the model, as in its scripts
)
# A name of one word that is a participle, gerund or preposition is neither verb nor noun (docs/glossary.md).
IRREGULAR_PARTICIPLES = set(
    "begun bent bound broken brought built caught chosen done drawn driven felt found frozen given gone grown held "
    "hidden kept known laid left lent lost made meant met paid risen said seen sent shown sought spent spoken stood "
    "stuck taken taught told torn understood woven wound written".split()
)
PREPOSITIONS = set(
    "about above across after against along among around at before behind below beneath beside between beyond by "
    "during for from in inside into near of off on onto out outside over past per since than through to toward "
    "under until up upon via with within without".split()
)
# Nouns and verbs that end like a participle or gerund.
NOUNS = set(
    "bearing bed belongs bring damping embed exceed feed forcing heading mapping need ping proceed ring rolling seed speed "
    "spring string thing warning wing".split()
)
# "file: function" of public names, which stay.
PUBLIC_PARTICIPLES = frozenset(
    {
        "analysis/kinematics/velocity_ratios.py: along",
        "analysis/kinematics/velocity_ratios.py: at",
        "analysis/kinematics/velocity_ratios.py: holding",
        "equations/equation_set.py: formed",
        "simulation/inputs/tables.py: at",
        "simulation/methods/constraints.py: applied",
        "simulation/results/trajectory.py: at",
        "simulation/sweeps/result.py: succeeded",
    }
)
# Locals with these names say nothing about their content; read at once they do no harm.
EMPTY_LOCALS, LOCAL_LIFE = {"found", "known", "own", "rest", "told", "wanted"}, 10
# Folders that must not ask which joint they have in hand.
JOINT_BLIND = ("analysis", "equations", "simulation")

Rule = Callable[[str, str], Iterator[str]]


@lru_cache(maxsize=1)
def nodes(text: str) -> tuple[ast.AST, ...]:
    """All nodes of a file, which one rule after the other reads."""
    return tuple(ast.walk(ast.parse(text)))


def functions(text: str) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    for node in nodes(text):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node


def last_name(node: ast.expr) -> str:
    """The name that is called or decorated with: ``c`` of ``a.b.c(...)``."""
    if isinstance(node, ast.Call):
        return last_name(node.func)
    return node.attr if isinstance(node, ast.Attribute) else node.id if isinstance(node, ast.Name) else ""


def calls(text: str) -> Iterator[ast.Call]:
    return (node for node in nodes(text) if isinstance(node, ast.Call))


def long_file(path: str, text: str) -> Iterator[str]:
    lines = text.count("\n")
    if lines > MAX_FILE:
        yield f"{lines} lines, at most {MAX_FILE}"


def long_function(path: str, text: str) -> Iterator[str]:
    for node in functions(text):
        # Docstrings do not count: those of public functions say every parameter and show an example.
        docstring = (ast.get_docstring(node, clean=False) or "").count("\n")
        lines = (node.end_lineno or node.lineno) - node.lineno + 1 - docstring
        if lines > MAX_FUNCTION:
            yield f"{node.name} has {lines} lines, at most {MAX_FUNCTION}"


def import_inside_function(path: str, text: str) -> Iterator[str]:
    for function in functions(text):
        for node in ast.walk(function):
            if isinstance(node, ast.Import):
                modules = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                modules = ["." * node.level + (node.module or "")]
            else:
                continue
            for module in modules:
                if module.partition(".")[0] not in EXTRAS:
                    yield f"{function.name} imports {module}: imports stand at the top"


def drawer(path: str, text: str) -> Iterator[str]:
    for part in Path(path).with_suffix("").parts:
        if part in DRAWERS:
            yield f"{part!r} is a drawer, not a thing: name the file after what it defines"


def guessing(path: str, text: str) -> Iterator[str]:
    for node in nodes(text):
        if isinstance(node, ast.Global):
            yield f"line {node.lineno}: global"
        elif isinstance(node, ast.Call) and last_name(node) == "hasattr":
            yield f"line {node.lineno}: hasattr"
    if "type: ignore" not in text:
        return
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT and "type: ignore" in token.string:
            yield f"line {token.start[0]}: type: ignore"


def mutable_dataclass(path: str, text: str) -> Iterator[str]:
    for node in nodes(text):
        if not isinstance(node, ast.ClassDef) or f"{path}: {node.name}" in MUTABLE_DATACLASSES:
            continue
        for decorator in node.decorator_list:
            if last_name(decorator) == "dataclass" and not _says_frozen(decorator):
                yield f"line {node.lineno}: {node.name} is not frozen"


def _says_frozen(decorator: ast.expr) -> bool:
    keywords = decorator.keywords if isinstance(decorator, ast.Call) else []
    return any(
        keyword.arg == "frozen" and isinstance(keyword.value, ast.Constant) and keyword.value.value is True
        for keyword in keywords
    )


def text_to_code(path: str, text: str) -> Iterator[str]:
    for node in calls(text):
        if last_name(node) in TEXT_TO_CODE:
            yield f"line {node.lineno}: {last_name(node)} turns text into code"


def asks_which_joint(path: str, text: str) -> Iterator[str]:
    if not path.startswith(JOINT_BLIND):
        return
    for node in calls(text):
        if last_name(node) == "isinstance" and "Joint" in ast.unparse(node.args[1]):
            yield f"line {node.lineno}: asks which joint it has; a joint answers for itself"


def is_bare_participle(name: str) -> bool:
    word = name.strip("_").lower()
    return (
        "_" not in word
        and word not in NOUNS
        and (word in IRREGULAR_PARTICIPLES or word in PREPOSITIONS or word.endswith(("ed", "ing")))
    )


def bare_participle(path: str, text: str) -> Iterator[str]:
    for node in functions(text):
        if is_bare_participle(node.name) and f"{path}: {node.name}" not in PUBLIC_PARTICIPLES:
            yield f"line {node.lineno}: {node.name} is neither a verb nor a noun"


def empty_local(path: str, text: str) -> Iterator[str]:
    if not any(name in text for name in EMPTY_LOCALS):
        return
    for function in functions(text):
        lines: dict[str, list[int]] = {}
        for node in ast.walk(function):
            if isinstance(node, ast.Name | ast.arg):
                name = node.id if isinstance(node, ast.Name) else node.arg
                if name in EMPTY_LOCALS:
                    lines.setdefault(name, []).append(node.lineno)
        for name, places in lines.items():
            if max(places) - min(places) > LOCAL_LIFE:
                yield f"line {min(places)}: {name} lives for {max(places) - min(places)} lines"


# Each rule, and a file (path, text) that breaks it.
RULES: dict[str, tuple[Rule, str, str]] = {
    "long file": (long_file, "model/body.py", "x = 1\n" * (MAX_FILE + 1)),
    "long function": (long_function, "model/body.py", "def f():\n" + "    x = 1\n" * MAX_FUNCTION),
    "own import inside function": (
        import_inside_function,
        "model/body.py",
        "def f():\n    from symbody.model import joint\n",
    ),
    "relative import inside function": (
        import_inside_function,
        "model/body.py",
        "def f():\n    from . import joint\n",
    ),
    "package import inside function": (
        import_inside_function,
        "model/body.py",
        "class A:\n    def f(self):\n        import numpy\n",
    ),
    "drawer": (drawer, "model/utils.py", ""),
    "drawer folder": (drawer, "common/body.py", ""),
    "global": (guessing, "model/body.py", "def f():\n    global x\n    x = 1\n"),
    "hasattr": (guessing, "model/body.py", "y = hasattr(1, 'real')\n"),
    "type: ignore": (guessing, "model/body.py", "y = 1  # type: ignore[assignment]\n"),
    "bare dataclass": (mutable_dataclass, "model/body.py", "@dataclass\nclass A:\n    x: int\n"),
    "slotted dataclass": (
        mutable_dataclass,
        "model/body.py",
        "@dataclass(slots=True)\nclass A:\n    x: int\n",
    ),
    "dataclass(frozen=False)": (
        mutable_dataclass,
        "model/body.py",
        "@dataclasses.dataclass(frozen=False)\nclass A:\n    x: int\n",
    ),
    "eval": (text_to_code, "model/body.py", "y = eval('1')\n"),
    "sympify": (text_to_code, "model/body.py", "y = sympy.sympify('x')\n"),
    "isinstance of a joint": (
        asks_which_joint,
        "equations/form.py",
        "y = isinstance(a, (Body, RevoluteJoint))\n",
    ),
    "participle": (bare_participle, "model/body.py", "def moved():\n    pass\n"),
    "irregular participle": (bare_participle, "model/body.py", "def _found():\n    pass\n"),
    "preposition": (bare_participle, "model/body.py", "class A:\n    def of(self):\n        pass\n"),
    "gerund": (bare_participle, "model/body.py", "def crossing():\n    pass\n"),
    "empty local": (
        empty_local,
        "model/body.py",
        "def f():\n    found = 1\n" + "    x = 1\n" * LOCAL_LIFE + "    return found\n",
    ),
}


def test_source_obeys() -> None:
    rules = dict.fromkeys(rule for rule, _, _ in RULES.values())
    offences = [
        f"{name}: {rule.__name__}: {offence}"
        for path in FILES
        for name, text in [(path.relative_to(SOURCE).as_posix(), path.read_text(encoding="utf-8"))]
        for rule in rules
        for offence in rule(name, text)
    ]
    assert not offences, "\n" + "\n".join(offences)


@pytest.mark.parametrize("offence", RULES)
def test_rule_catches(offence: str) -> None:
    rule, path, text = RULES[offence]
    assert list(rule(path, text))


@pytest.mark.parametrize(
    "rule", {rule: None for rule, _, _ in RULES.values()}, ids=lambda rule: rule.__name__
)
def test_rule_lets_good_code_pass(rule: Rule) -> None:
    good = (
        '"""A body."""\nimport re\n@dataclass(frozen=True, slots=True)\nclass Body:\n    mass: str\n'
        "def table():\n    import pandas\n    return pandas\npattern = re.compile('eval(')\n"
        "heavy = isinstance(Body('1'), Body)\n"
    )
    assert not list(rule("equations/body.py", good))


def test_files_are_small_on_the_whole() -> None:
    sizes = [path.read_text(encoding="utf-8").count("\n") for path in FILES if path.suffix == ".py"]
    assert statistics.median(sizes) <= MAX_MEDIAN


def test_class_names_are_unique() -> None:
    places: dict[str, list[str]] = {}
    for path in FILES:
        if path.suffix == ".py":
            for name in re.findall(r"^ *class (\w+)[(:\[]", path.read_text(encoding="utf-8"), re.MULTILINE):
                places.setdefault(name, []).append(path.relative_to(SOURCE).as_posix())
    assert len(places) > 700
    doubles = {name: files for name, files in places.items() if len(files) > 1}
    assert not doubles


def test_file_names_are_unique_in_each_top_folder() -> None:
    places: dict[tuple[str, str], list[str]] = {}
    for path in FILES:
        if path.suffix == ".py" and path.stem != "__init__":
            relative = path.relative_to(SOURCE)
            places.setdefault((relative.parts[0], path.stem), []).append(relative.as_posix())
    doubles = {name: files for name, files in places.items() if len(files) > 1}
    assert not doubles


def test_every_package_is_typed_and_lazy() -> None:
    assert (SOURCE / "py.typed").exists()
    for init in SOURCE.rglob("__init__.pyi"):
        assert "attach_stub" in init.with_suffix(".py").read_text(encoding="utf-8"), f"{init} is never read"
