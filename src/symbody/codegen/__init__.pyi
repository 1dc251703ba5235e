from .compile import compile as compile
from .function import CompiledFunction as CompiledFunction
