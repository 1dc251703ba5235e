from .explicit import Explicit as Explicit
from .simulate import simulate as simulate
from .status import Status as Status
from .trajectory import Trajectory as Trajectory
