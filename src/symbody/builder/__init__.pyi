from .app import make_app as make_app
from .run import run_builder as run_builder
from .settings import BuilderSettings as BuilderSettings
from .settings import make_settings as make_settings
