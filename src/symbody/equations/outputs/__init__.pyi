from . import equation_lines as equation_lines
from . import output_table as output_table
from . import textbook as textbook
