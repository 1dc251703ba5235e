"""Machine code through LLVM: functions of one point, and the same ones of several points at once."""

from symbody.errors import EnvironmentFault, Problem

try:  # here, before any file of this folder needs it
    import llvmlite.binding.ffi  # noqa: F401
except (ImportError, OSError) as error:
    raise EnvironmentFault(
        Problem("environment.llvmlite", "", "equations cannot be compiled: llvmlite does not load",
                str(error).partition("\n")[0], "pip install --force-reinstall llvmlite")
    ) from error  # fmt: skip
