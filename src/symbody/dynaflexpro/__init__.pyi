from .build import BuildEQs as BuildEQs
from .exports import ModelEquations as ModelEquations
from .sim_code import BuildSimCode as BuildSimCode
