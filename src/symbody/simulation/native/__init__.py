"""The loop that numba compiles once for every model, and the methods it runs."""

from symbody.errors import EnvironmentFault, Problem

try:  # here, before any file of this folder needs it
    import numba.core.registry  # noqa: F401
except (ImportError, OSError) as error:
    raise EnvironmentFault(
        Problem("environment.numba", "", "motions cannot be computed: numba does not load",
                str(error).partition("\n")[0], "pip install --force-reinstall numba")
    ) from error  # fmt: skip
