from .native import from_data as from_data
from .native import layout_of as layout_of
from .native import load_model as load_model
from .native import model_from_toml as model_from_toml
from .native import model_to_toml as model_to_toml
from .native import save_model as save_model
from .native import to_data as to_data
