from .build import BuildEQs as BuildEQs
from .build import BuildModel as BuildModel
from .exports import ModelEquations as ModelEquations
from .sim_code import BuildSimCode as BuildSimCode
