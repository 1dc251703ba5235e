from .compile import compile as compile
from .compile import generate_code as generate_code
from .function import CompiledFunction as CompiledFunction
