from .pictures import draw_scene as draw_scene
from .save_animation import save_animation as save_animation
from .studio import Look as Look
