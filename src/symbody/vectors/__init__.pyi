from .frame import FrameTree as FrameTree
from .rotation import Rotation as Rotation
from .rotation import Turn as Turn
from .vector import Vector as Vector
from .vector import cross as cross
from .vector import dot as dot
