from . import sympy_reader as sympy_reader
from . import sympy_writer as sympy_writer
