from .dynamics.virtual_work import VirtualWork as VirtualWork
from .equation_set import EquationSet as EquationSet
from .form import form_equations as form_equations
