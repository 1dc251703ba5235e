"""Planted defects: how many mistakes in lines that the fast tier executes do its tests find?

    python -m tests.planted_defects run RECORD [arguments of pytest]
    python -m tests.planted_defects draw RECORD --seed 1 --count 30 >places.json
    python -m tests.planted_defects judge RECORD places.json [--seconds 600] >judged.jsonl

`run` appends to a record, a file of lines of JSON, which blocks of `src/symbody` each file of tests executes in
this process, and the processor time of each test; call it once for all tests or folder by folder. `draw` chooses
places in these blocks: signs, indices, terms, and keys of caches in turn. `judge` makes one mistake after the
other in a copy of the package and runs the files of tests that execute its block, those of the same folder first,
until one fails. Kernels are read as text and compiled, so their own lines are no blocks.
"""

from __future__ import annotations

import argparse
import ast
import builtins
import copy
import importlib.abc
import importlib.machinery
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "symbody"
MARKS = "_executed_blocks"  # in builtins: one byte a block
RECORD = "SYMBODY_RECORD_OF_BLOCKS"
KINDS = ("sign", "index", "term", "cache")
Block = tuple[str, int, int]  # file below the package, first and last line


# Which blocks are executed.


class _Marker(ast.NodeTransformer):
    """Begins each block of a function with a mark."""

    def __init__(self, file: str, first: int) -> None:
        self.file, self.first = file, first
        self.blocks: list[Block] = []

    def _mark(self, statements: list[ast.stmt]) -> ast.stmt:
        line = statements[0].lineno
        self.blocks.append((self.file, line, statements[-1].end_lineno or line))
        place = self.first + len(self.blocks) - 1
        mark = ast.parse(f"{MARKS}[{place}] = 1").body[0]
        return ast.fix_missing_locations(ast.copy_location(mark, statements[0]))

    def _block(self, statements: list[ast.stmt]) -> list[ast.stmt]:
        """Return statements with marks: at first, and behind each that may leave the block."""
        made: list[ast.stmt] = []
        begun: list[ast.stmt] = []
        for statement in statements:
            begun.append(statement)
            if isinstance(statement, (ast.If, ast.For, ast.While, ast.Try, ast.With, ast.Match)):
                made += [self._mark(begun), *begun]
                begun = []
        if begun:
            made += [self._mark(begun), *begun]
        return [self._within(statement) if not _is_mark(statement) else statement for statement in made]

    def _within(self, statement: ast.stmt) -> ast.stmt:
        for field in ("body", "orelse", "finalbody"):
            inner = getattr(statement, field, None)
            if inner:
                setattr(statement, field, self._block(inner))
        for inner in (*getattr(statement, "handlers", ()), *getattr(statement, "cases", ())):
            inner.body = self._block(inner.body)
        return statement

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        has_text = ast.get_docstring(node, clean=False) is not None
        if node.body[has_text:]:
            node.body = node.body[:has_text] + self._block(node.body[has_text:])
        return node


def _is_mark(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Assign) and ast.unparse(statement.targets[0]).startswith(f"{MARKS}[")


def mark_blocks(text: str, file: str, first: int) -> tuple[ast.Module, list[Block]]:
    """Return a module whose functions mark the blocks that they execute, from a number on, and the blocks."""
    marker = _Marker(file, first)
    return marker.visit(ast.parse(text)), marker.blocks


class _Loader(importlib.machinery.SourceFileLoader):
    """Loads a module with marks; what is kept as bytecode has none."""

    blocks: list[Block] = []

    def get_code(self, fullname: str) -> Any:
        path = self.get_filename(fullname)
        tree, found = mark_blocks(
            self.get_data(path).decode(), str(Path(path).relative_to(PACKAGE)), len(self.blocks)
        )
        self.blocks.extend(found)
        getattr(builtins, MARKS).extend(bytes(len(found)))
        return compile(tree, path, "exec", dont_inherit=True)


class _Finder(importlib.abc.MetaPathFinder):
    def find_spec(self, name: str, path: Any, target: Any = None) -> Any:
        if name.partition(".")[0] != "symbody" or name.startswith("symbody.kernels"):
            return None
        found = importlib.machinery.PathFinder.find_spec(name, path, target)
        if found is not None and found.origin and found.origin.endswith(".py"):
            found.loader = _Loader(name, found.origin)
        return found


def processor_seconds() -> float:
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


class _Recorder:
    """Writes a line for each file of tests: its blocks, and the processor seconds of its tests."""

    def __init__(self, path: str) -> None:
        self.path, self.seconds = path, dict[str, float]()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> Iterator[None]:
        begun = processor_seconds()
        try:
            return (yield)
        finally:
            self.seconds[item.nodeid] = round(processor_seconds() - begun, 3)
            if nextitem is None or nextitem.path != item.path:
                self._write(item.nodeid.partition("::")[0])

    def _write(self, file: str) -> None:
        marks = getattr(builtins, MARKS)
        blocks = [_Loader.blocks[k] for k, mark in enumerate(marks) if mark]
        with open(self.path, "a") as record:
            record.write(json.dumps({"tests": file, "seconds": self.seconds, "blocks": blocks}) + "\n")
        marks[:] = bytes(len(marks))
        self.seconds = {}


def pytest_configure(config: pytest.Config) -> None:
    """Record, as a plugin that `run` asks for."""
    if path := os.environ.get(RECORD):
        setattr(builtins, MARKS, bytearray())
        sys.meta_path.insert(0, _Finder())
        config.pluginmanager.register(_Recorder(path))


# Mistakes.


@dataclass(frozen=True)
class Place:
    """A mistake: a piece of a file, in bytes, and what stands there instead."""

    kind: str
    file: str
    line: int
    begin: int
    end: int
    before: str
    after: str


def mistakes(text: str, file: str) -> list[Place]:
    """Return all mistakes that can be made in the functions of a file."""
    starts = [0]
    for line in text.encode().splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    found = []
    for function in ast.walk(ast.parse(text)):
        if not isinstance(function, ast.FunctionDef):
            continue
        for statement in function.body:
            for node in ast.walk(statement):
                for kind, other in _mistakes_at(node):
                    begin = starts[node.lineno - 1] + node.col_offset
                    end = starts[(node.end_lineno or 0) - 1] + (node.end_col_offset or 0)
                    before = text.encode()[begin:end].decode()
                    found.append(Place(kind, file, node.lineno, begin, end, before, other))
    return list(dict.fromkeys(found))  # functions within functions are seen twice


def _mistakes_at(node: ast.AST) -> Iterator[tuple[str, str]]:
    if isinstance(node, ast.BinOp) and isinstance(node.op, (ast.Add, ast.Sub)):
        if not any(isinstance(each, (ast.JoinedStr, ast.Constant)) and not _is_number(each)
                   for each in (node.left, node.right)):  # fmt: skip
            turned = copy.copy(node)
            turned.op = ast.Sub() if isinstance(node.op, ast.Add) else ast.Add()
            yield "sign", f"({ast.unparse(turned)})"
            yield "term", f"({ast.unparse(node.left)})"
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield "sign", f"({ast.unparse(node.operand)})"
    elif isinstance(node, ast.BoolOp):
        kept = copy.copy(node)
        kept.values = node.values[:-1]
        yield "term", f"({ast.unparse(kept if len(kept.values) > 1 else kept.values[0])})"
    elif isinstance(node, ast.Subscript):
        for other in _other_indices(node):
            yield "index", ast.unparse(other)
    elif isinstance(node, ast.Call):
        yield from _stale(node)


def _is_number(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, (int, float))


def _other_indices(node: ast.Subscript) -> Iterator[ast.Subscript]:
    """Yield a subscript with each of its whole numbers larger by one."""
    count = sum(_is_index(each) for each in ast.walk(node.slice))
    for k in range(count):
        other = copy.deepcopy(node)
        constant = [each for each in ast.walk(other.slice) if _is_index(each)][k]
        constant.value += 1
        yield other


def _is_index(node: ast.AST) -> Any:
    return isinstance(node, ast.Constant) and type(node.value) is int


def _stale(node: ast.Call) -> Iterator[tuple[str, str]]:
    """Yield the call of a cache whose key has lost what it depends on."""
    function = node.func
    if not (isinstance(function, ast.Attribute) and function.attr == "get" and len(node.args) == 2):
        return
    if isinstance(node.args[1], ast.Constant | ast.List | ast.Tuple | ast.Dict):
        return  # a value of a mapping, not of a cache
    other = copy.deepcopy(node)
    key = node.args[0]
    if isinstance(key, ast.Tuple) and len(key.elts) > 1 and not isinstance(key.elts[-1], ast.Constant):
        other.args[0] = ast.Tuple(key.elts[:-1], ast.Load())
    elif isinstance(key, ast.Name) and ast.unparse(function.value).endswith(("plans", "variants")):
        other.args[0] = ast.Constant("one key for all")
    else:
        return
    yield "cache", ast.unparse(other)


# Records, draws, judgments.


@dataclass(frozen=True)
class Record:
    """What `run` wrote: the files of tests of each block, and their processor seconds."""

    tests: Mapping[Block, frozenset[str]]
    seconds: Mapping[str, float]

    @classmethod
    def read(cls, path: Path) -> Record:
        tests: dict[Block, set[str]] = {}
        seconds: dict[str, float] = {}
        for line in path.read_text().splitlines():
            entry = json.loads(line)
            seconds[entry["tests"]] = sum(entry["seconds"].values())
            for file, first, last in entry["blocks"]:
                tests.setdefault((file, first, last), set()).add(entry["tests"])
        return cls({block: frozenset(files) for block, files in tests.items()}, seconds)

    def tests_of(self, place: Place) -> list[str]:
        """Return the files of tests that execute the innermost block of a place, near and fast ones first."""
        around = [b for b in self.tests if b[0] == place.file and b[1] <= place.line <= b[2]]
        files = self.tests[min(around, key=lambda b: b[2] - b[1])] if around else frozenset()
        room = place.file.partition("/")[0]
        return sorted(files, key=lambda file: (f"tests/{room}/" not in file, self.seconds[file], file))


def draw(record: Record, seed: int, count: int, package: Path = PACKAGE) -> list[Place]:
    """Return places in executed blocks, kinds in turn, at most one a file and kind."""
    chance = random.Random(seed)
    waiting: dict[str, list[Place]] = {kind: [] for kind in KINDS}
    for file in sorted({block[0] for block in record.tests}):
        for place in mistakes((package / file).read_text(), file):
            waiting[place.kind].append(place)
    for places in waiting.values():
        chance.shuffle(places)
    drawn: list[Place] = []
    while len(drawn) < count and any(waiting.values()):
        for kind in KINDS:
            while waiting[kind]:
                place = waiting[kind].pop()
                is_new = all((place.kind, place.file) != (each.kind, each.file) for each in drawn)
                if is_new and record.tests_of(place):
                    drawn.append(place)
                    break
    return drawn[:count]


def plant(place: Place, package: Path) -> None:
    """Make a mistake in a copy of the package."""
    path = package / place.file
    text = path.read_bytes()
    if text[place.begin : place.end].decode() != place.before:
        raise ValueError(f"{place.file} has changed since the draw")
    path.write_bytes(text[: place.begin] + place.after.encode() + text[place.end :])


def judge(
    place: Place, files: Sequence[str], seconds: float, run: Callable[..., Any] = subprocess.run
) -> str:
    """Return the first test that fails with a mistake alone; empty if none does, or the time is up."""
    end = time.monotonic() + seconds
    with tempfile.TemporaryDirectory() as first, tempfile.TemporaryDirectory() as second:
        planted, control = (_copy_checkout(Path(folder)) for folder in (first, second))
        plant(place, planted / "symbody")
        elsewhere: list[str] = []  # tests that fail in any copy
        for part in _parts(files):
            while True:
                try:
                    test = _first_failure(planted, [*part, *elsewhere], end, run)
                    if not test:
                        break
                    if "::" not in test or not _first_failure(control, [test], end, run):
                        return test
                except subprocess.TimeoutExpired:
                    return ""
                elsewhere += ["--deselect", test]
    return ""


def _copy_checkout(folder: Path) -> Path:
    """Copy the package, and link what lies beside it; return the folder to import from."""
    for path in ROOT.iterdir():
        if path.name not in ("src", ".git"):
            (folder / path.name).symlink_to(path)
    shutil.copytree(PACKAGE, folder / "src" / "symbody", ignore=shutil.ignore_patterns("__pycache__"))
    return folder / "src"


def _first_failure(source: Path, tests: Sequence[str], end: float, run: Callable[..., Any]) -> str:
    """Return the first test that fails with a copy of the package, or how pytest ends otherwise."""
    environment = {**os.environ, "PYTHONPATH": str(source), "SYMBODY_CACHE": str(source / "code")}
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-n",
        "0",
        "-x",
        "-q",
        "-rfE",
        "-p",
        "no:cacheprovider",
        *tests,
    ]
    done = run(
        command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=end - time.monotonic()
    )
    if done.returncode in (0, 5):  # 5: no test is left in the tier
        return ""
    lines = [line for line in done.stdout.splitlines() if line.startswith(("FAILED ", "ERROR "))]
    return lines[0].split(" ", 1)[1].partition(" - ")[0] if lines else f"pytest ended with {done.returncode}"


def _parts(files: Sequence[str]) -> list[Sequence[str]]:
    """Return some files at a time: processes begin slowly."""
    return [files[k : k + 8] for k in range(0, len(files), 8)]


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = parser.add_subparsers(dest="command", required=True)
    for name in ("run", "draw", "judge"):
        command = commands.add_parser(name)
        command.add_argument("record", type=Path)
        if name == "draw":
            command.add_argument("--seed", type=int, default=1)
            command.add_argument("--count", type=int, default=30)
        if name == "judge":
            command.add_argument("places", type=Path)
            command.add_argument("--seconds", type=float, default=600.0, help="for each place")
    given, more = parser.parse_known_args(arguments)
    if given.command == "run":
        environment = {**os.environ, RECORD: str(given.record.resolve())}
        command = [sys.executable, "-m", "pytest", "-n", "0", "-p", "tests.planted_defects", *more]
        sys.exit(subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode)
    record = Record.read(given.record)
    if given.command == "draw":
        print(json.dumps([asdict(place) for place in draw(record, given.seed, given.count)], indent=1))
        return
    for place in (Place(**entry) for entry in json.loads(given.places.read_text())):
        files = record.tests_of(place)
        found = judge(place, files, given.seconds)
        print(json.dumps({"found": found, "files": len(files), **asdict(place)}), flush=True)


if __name__ == "__main__":
    main()
