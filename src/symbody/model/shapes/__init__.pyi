from .shape import BodyShape as BodyShape
from .solids import Box as Box
from .solids import Capsule as Capsule
from .solids import Cone as Cone
from .solids import Cylinder as Cylinder
from .solids import Mesh as Mesh
from .solids import Sphere as Sphere
