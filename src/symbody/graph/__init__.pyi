from . import cycle as cycle
from .linear_graph import Edge as Edge
from .linear_graph import LinearGraph as LinearGraph
from .spanning_tree import spanning_tree as spanning_tree
from .topology import choose_topology as choose_topology
from .trees import Trees as Trees
