# what scripts hold in their hands
from .objects import BODY as BODY
from .objects import CONSTRAINT as CONSTRAINT
from .objects import FORCE as FORCE
from .objects import FRAME as FRAME
from .objects import POINT as POINT
from .objects import TORQUE as TORQUE
from .objects import VECTOR as VECTOR

# frames
from .frames import ground as ground
from .frames import inv_frame as inv_frame
from .frames import rotate as rotate
from .frames import translate as translate

# points and vectors
from .vectors import comp_X as comp_X
from .vectors import comp_XYZ as comp_XYZ
from .vectors import comp_Y as comp_Y
from .vectors import comp_Z as comp_Z
from .vectors import cross_prod as cross_prod
from .vectors import dot_prod as dot_prod
from .vectors import join_points as join_points
from .vectors import make_POINT as make_POINT
from .vectors import make_VECTOR as make_VECTOR
from .vectors import origin as origin
from .vectors import project as project
from .vectors import uvec_X as uvec_X
from .vectors import uvec_Y as uvec_Y
from .vectors import uvec_Z as uvec_Z

# their motion
from .vectors import acceleration as acceleration
from .vectors import angular_velocity as angular_velocity
from .vectors import velocity as velocity

# mechanics
from .mechanics import CoM as CoM
from .mechanics import make_BODY as make_BODY
from .mechanics import make_CONSTRAINT as make_CONSTRAINT
from .mechanics import make_FORCE as make_FORCE
from .mechanics import make_TORQUE as make_TORQUE
from .mechanics import set_gravity as set_gravity

# equations of motion
from .dynamics import Equations as Equations
from .dynamics import equation_set as equation_set
from .dynamics import euler_equations as euler_equations
from .dynamics import gravitational_energy as gravitational_energy
from .dynamics import kinetic_energy as kinetic_energy
from .dynamics import lagrange_equations as lagrange_equations
from .dynamics import newton_equations as newton_equations

# lists of equations
from .lists import GenerateMatrix as GenerateMatrix
from .lists import LUMethod as LUMethod
from .lists import diff as diff
from .lists import first_order as first_order
from .lists import linearize as linearize
from .lists import state_space as state_space

# help
from .help import Describe as Describe
from .help import show as show
