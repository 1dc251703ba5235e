from .dc_motor import DCMotor as DCMotor
from .delay import Delay as Delay
from .first_order import FirstOrder as FirstOrder
from .hysteresis import Hysteresis as Hysteresis
from .pid import PID as PID
from .rate_limit import RateLimit as RateLimit
from .state_space import StateSpace as StateSpace
from .transfer_function import TransferFunction as TransferFunction
