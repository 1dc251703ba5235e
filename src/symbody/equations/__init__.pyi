from .equation_set import EquationSet as EquationSet
from .form import form_equations as form_equations
from .formulations.lagrange import Lagrange as Lagrange
from .formulations.newton_euler import NewtonEuler as NewtonEuler
from .formulations.virtual_work import VirtualWork as VirtualWork
