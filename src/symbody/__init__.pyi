# The public surface; the headings are those of the reference. attach_stub reads this file at run time:
# only lines of the form "from .module import name".

__version__: str

# Model and elements
from .model import Body as Body
from .model import Frame as Frame
from .model import Model as Model
from .model import Include as Include
from .model import Initial as Initial
from .formats import load_model as load_model
from .formats import save_model as save_model
from .formats import load_urdf as load_urdf
from .formats import save_urdf as save_urdf
from .model import without_sampling as without_sampling

# Model and elements: joints
from .model import Bearing as Bearing
from .model import Cartesian as Cartesian
from .model import ConstantVelocity as ConstantVelocity
from .model import Cylindrical as Cylindrical
from .model import Free as Free
from .model import Gimbal as Gimbal
from .model import PinSlot as PinSlot
from .model import Planar as Planar
from .model import Prismatic as Prismatic
from .model import Rectangular as Rectangular
from .model import Revolute as Revolute
from .model import Screw as Screw
from .model import Spherical as Spherical
from .model import Telescoping as Telescoping
from .model import Universal as Universal
from .model import Weld as Weld

# Model and elements: constraints
from .model import Angle as Angle
from .model import Belt as Belt
from .model import Constraint as Constraint
from .model import Differential as Differential
from .model import Distance as Distance
from .model import Gear as Gear
from .model import KnifeEdge as KnifeEdge
from .model import Parallel as Parallel
from .model import Perpendicular as Perpendicular
from .model import PointOnCurve as PointOnCurve
from .model import PointOnLine as PointOnLine
from .model import PointOnPlane as PointOnPlane
from .model import PointOnSurface as PointOnSurface
from .model import RackPinion as RackPinion
from .model import Rolling as Rolling
from .model import Stop as Stop
from .model import Curve as Curve

# Model and elements: forces
from .model import Backlash as Backlash
from .model import Bushing as Bushing
from .model import Contact as Contact
from .model import Drive as Drive
from .model import Force as Force
from .model import Friction as Friction
from .model import Limits as Limits
from .model import NormalForce as NormalForce
from .model import SpringDamper as SpringDamper
from .model import Torque as Torque
from .model import TorsionSpring as TorsionSpring

# Model and elements: signals
from .model import DCMotor as DCMotor
from .model import Delay as Delay
from .model import FirstOrder as FirstOrder
from .model import Hysteresis as Hysteresis
from .model import Lookup as Lookup
from .model import PID as PID
from .model import RateLimit as RateLimit
from .model import Signal as Signal
from .model import StateSpace as StateSpace
from .model import TransferFunction as TransferFunction

# Model and elements: shapes
from .model import Box as Box
from .model import Capsule as Capsule
from .model import Cone as Cone
from .model import Cylinder as Cylinder
from .model import Mesh as Mesh
from .model import Sphere as Sphere

# Equations
from .equations import form_equations as form_equations
from .equations import EquationSet as EquationSet
from .graph import Trees as Trees
from .equations import VirtualWork as VirtualWork
from .equations import NewtonEuler as NewtonEuler
from .equations import Lagrange as Lagrange
from .equations import Recursive as Recursive
from .equations import reduce_index as reduce_index
from .equations import IndexReduction as IndexReduction
from .equations import separate_derivatives as separate_derivatives
from .equations import Separation as Separation

# Kinematics
from .analysis import assemble as assemble
from .analysis import State as State
from .analysis import solve_positions as solve_positions
from .analysis import PositionSolutions as PositionSolutions
from .analysis import trace_positions as trace_positions
from .analysis import Positions as Positions
from .analysis import velocity_ratios as velocity_ratios
from .analysis import VelocityRatios as VelocityRatios
from .analysis import singular_configurations as singular_configurations
from .analysis import SingularConfiguration as SingularConfiguration
from .analysis import redundancy as redundancy
from .analysis import Redundancy as Redundancy

# Simulation
from .simulation import simulate as simulate
from .simulation import sweep as sweep
from .simulation import Stepper as Stepper
from .simulation import LaneStepper as LaneStepper
from .simulation import inverse_dynamics as inverse_dynamics
from .analysis import solve_index_1 as solve_index_1
from .simulation import Event as Event
from .simulation import Table as Table
from .simulation import FmuInput as FmuInput
from .simulation import Explicit as Explicit
from .simulation import FixedStep as FixedStep
from .simulation import Stiff as Stiff
from .simulation import GeneralizedAlpha as GeneralizedAlpha
from .simulation import MoreauJean as MoreauJean
from .simulation import Projection as Projection
from .simulation import Partition as Partition
from .simulation import Baumgarte as Baumgarte
from .simulation import GGL as GGL

# Results
from .simulation import Trajectory as Trajectory
from .simulation import Status as Status
from .simulation import Sweep as Sweep
from .simulation import Samples as Samples
from .analysis import IndexOneSolution as IndexOneSolution
from .report import save_report as save_report

# Linear analysis
from .analysis import find_equilibrium as find_equilibrium
from .analysis import Equilibrium as Equilibrium
from .analysis import linearize as linearize
from .analysis import Linearization as Linearization
from .analysis import Mode as Mode

# Code and FMU
from .codegen import compile as compile
from .codegen import CompiledFunction as CompiledFunction
from .simulation import generate_code as generate_code
from .simulation import generate_simulation as generate_simulation
from .fmu import save_fmu as save_fmu
from .fmu import Fmu as Fmu
from .fmu import FmuVariable as FmuVariable

# Pictures
from .visual import plot as plot
from .visual import save_plot as save_plot
from .visual import animate as animate
from .visual import Animation as Animation
from .visual import save_animation as save_animation

# Errors
from .errors import SymbodyError as SymbodyError
from .errors import Problem as Problem
from .errors import AssemblyError as AssemblyError
from .errors import CallError as CallError
from .errors import CompileError as CompileError
from .errors import EnvironmentFault as EnvironmentFault
from .errors import ExpressionError as ExpressionError
from .errors import FormatError as FormatError
from .errors import FormulationError as FormulationError
from .errors import FrameError as FrameError
from .errors import ModelError as ModelError
from .errors import ResourceError as ResourceError
from .errors import SimulationError as SimulationError
from .errors import TimeLimitError as TimeLimitError
from .errors import TopologyError as TopologyError
from .errors import UsageError as UsageError
