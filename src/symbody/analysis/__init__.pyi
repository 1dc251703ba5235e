from .assembly import assemble as assemble
from .state import State as State
