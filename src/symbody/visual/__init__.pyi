from .film import draw_scene as draw_scene
from .film import save_animation as save_animation
from .plotting.plot import plot as plot
from .plotting.plot import save_plot as save_plot
from .viewer.animation import Animation as Animation
from .viewer.animation import animate as animate
