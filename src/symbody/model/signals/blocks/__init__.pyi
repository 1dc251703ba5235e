from .dc_motor import DCMotor as DCMotor
from .limits import Hysteresis as Hysteresis
from .limits import RateLimit as RateLimit
from .linear_blocks import Delay as Delay
from .linear_blocks import FirstOrder as FirstOrder
from .linear_blocks import StateSpace as StateSpace
from .linear_blocks import TransferFunction as TransferFunction
from .pid import PID as PID
