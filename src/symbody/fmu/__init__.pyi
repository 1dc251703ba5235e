from .export import Fmu as Fmu
from .export import save_fmu as save_fmu
from .variables import FmuVariable as FmuVariable
