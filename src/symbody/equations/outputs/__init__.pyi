from . import equation_lines as equation_lines
from . import textbook as textbook
