from .animation import Animation as Animation
from .animation import animate as animate
from .plot import plot as plot
from .plot import save_plot as save_plot
