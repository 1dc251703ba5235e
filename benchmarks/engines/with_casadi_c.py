"""CasADi's generated C, compiled with a C compiler: the same function as CasADi's interpreter runs."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import casadi

from benchmarks.engines import with_casadi
from benchmarks.engines.algebra import Compiled, Scalar


class Engine(with_casadi.Engine):
    """CasADi followed by a C compiler."""

    def compile(self, outputs: Sequence[Scalar]) -> Compiled:
        """Return machine code."""
        function = self.function(outputs)
        folder = TemporaryDirectory()
        generator = casadi.CodeGenerator("f.c")
        generator.add(function)
        generator.generate(f"{folder.name}/")
        library = Path(folder.name, "f.so")
        compiler = shutil.which("cc")
        if compiler is None:
            raise FileNotFoundError("no C compiler named cc")
        options = ["-O3", "-march=native", "-shared", "-fPIC"]
        subprocess.run([compiler, *options, f"{folder.name}/f.c", "-o", str(library), "-lm"], check=True)
        return with_casadi.compiled(casadi.external("f", str(library)), function, folder)
