from .constraints import Baumgarte as Baumgarte
from .constraints import Projection as Projection
from .explicit import Explicit as Explicit
from .simulate import simulate as simulate
from .status import Status as Status
from .trajectory import Trajectory as Trajectory
