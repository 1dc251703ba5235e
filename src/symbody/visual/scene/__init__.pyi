from .from_model import make_scene as make_scene
from .json_form import motion_to_json as motion_to_json
from .json_form import scene_to_json as scene_to_json
from .motion import coordinate_courses as coordinate_courses
from .motion import make_motion as make_motion
from .scene import Scene as Scene
from .scene import SceneMotion as SceneMotion
