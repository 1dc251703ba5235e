"""The benchmarks at tiny size and without peers: that the tables come, and that they tell the truth."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from functools import partial

import numpy as np
import pytest
from rich.console import Console

from benchmarks import expressions, nodes
from benchmarks.engines.counting import count_operations
from benchmarks.engines.engine import Engine
from benchmarks.engines.ours import Engine as OurEngine
from benchmarks.problems import Problem, pendulum, random_operations, random_program, serial_chain
from benchmarks.process import Process, Step, Task
from benchmarks.table import Table, ratio_text, seconds_text, show
from benchmarks.timing import Settings, in_turns, medians, seconds_per_call

ONCE = Settings(limit=30.0, rounds=1)
ABSENT = Engine("Absent", "no_such_package", "no_such_package", "Engine")
