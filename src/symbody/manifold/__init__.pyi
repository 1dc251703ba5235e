from .branch import Branch as Branch
from .branch import explore_branch as explore_branch
from .manifold import ConstraintManifold as ConstraintManifold
from .manifold import Projection as Projection
from .manifold import constraint_manifold as constraint_manifold
from .ranks import independent_columns as independent_columns
from .ranks import independent_rows as independent_rows
from .ranks import rank as rank
