"""Closed solutions within a time: SymPy runs in a process that is stopped when the time is up."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Sequence
from threading import TIMEOUT_MAX

import sympy as sp

from symbody.errors import FormulationError, Problem
from symbody.expr.graph import Graph
from symbody.expr.rewrite import symbols_of
from symbody.expr.sympy.sympy_bridge import to_sympy
from symbody.expr.sympy.sympy_reader import nodes_from_sympy


def solve_within(
    graph: Graph, equations: Sequence[int], unknowns: Sequence[int], seconds: float
) -> list[list[int]]:
    """Return the solutions of equations as nodes, one list a solution, one node an unknown.

    Raises
    ------
    FormulationError
        If they are not found within `seconds`.
    """
    symbols = symbols_of(graph, [*equations, *unknowns])
    plain = [sp.Symbol(f"w{k}", real=True) for k in range(len(symbols))]
    renamed = dict(zip(to_sympy(graph, symbols), plain, strict=True))
    rows = [row.subs(renamed, simultaneous=True) for row in to_sympy(graph, equations)]
    wanted = [plain[symbols.index(node)] for node in unknowns]
    answer = _read_answer(rows, wanted, seconds)
    owners = {x.name: graph.symbols[graph.left[node]] for x, node in zip(plain, symbols, strict=True)}
    values = [solution[x] for solution in answer for x in wanted]
    nodes = nodes_from_sympy(values, graph, lambda name, of_time: owners[name])
    width = len(unknowns)
    return [nodes[k * width : (k + 1) * width] for k in range(len(answer))]


def _read_answer(
    rows: Sequence[sp.Expr], unknowns: Sequence[sp.Symbol], seconds: float
) -> list[dict[sp.Symbol, sp.Expr]]:
    """Return the answer of the process."""
    question = pickle.dumps((rows, unknowns))
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    command = [sys.executable, "-m", "symbody.expr.solving.worker"]
    try:
        run = subprocess.run(
            command,
            input=question,
            capture_output=True,
            timeout=min(seconds, TIMEOUT_MAX),
            env=environment,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise FormulationError(
            Problem("positions.time", "positions", f"no closed form was found in {seconds:g} s",
                    "the equations may have none, or one too long to print",
                    "allow more seconds=, choose other dependent coordinates, or solve with numbers by "
                    "assemble()")
        ) from error  # fmt: skip
    if run.returncode:
        last = run.stderr.decode(errors="replace").strip().rpartition("\n")[2]
        raise FormulationError(
            Problem("positions.failed", "positions", "SymPy failed to solve the equations", last,
                    "choose other dependent coordinates, or solve with numbers by assemble()")
        )  # fmt: skip
    answer: list[dict[sp.Symbol, sp.Expr]] = pickle.loads(run.stdout)
    return answer
