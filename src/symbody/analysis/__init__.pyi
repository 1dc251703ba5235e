from .assembly import assemble as assemble
from .redundancy import Redundancy as Redundancy
from .redundancy import redundancy as redundancy
from .state import State as State
