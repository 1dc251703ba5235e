from .plot import plot as plot
from .plot import save_plot as save_plot
