"""A configuration as a motion of one sample."""

from __future__ import annotations

import numpy as np

from symbody.analysis.scales import mechanism_scales
from symbody.analysis.state import State
from symbody.simulation.inputs.input_laws import input_laws
from symbody.simulation.native.run import Statistics
from symbody.simulation.results.provenance import provenance_of
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.simulation_problem import Evaluator, SimulationProblem
from symbody.simulation.status import Status


def run_of_state(state: State) -> Trajectory:
    """Return a motion that is at one configuration, with everything that can be computed there."""
    eqs = state.eqs
    laws = input_laws(eqs.input_names, state.inputs, (state.t, state.t), len(eqs.coordinate_names))
    scales = mechanism_scales(eqs, state.parameters, near=state.q)
    return Trajectory(
        t=np.array([state.t]),
        q=np.array([list(state.q.values())]).reshape(1, -1).T,
        u=np.array([list(state.u.values())]).reshape(1, -1).T,
        coordinate_names=eqs.coordinate_names,
        speed_names=eqs.speed_names,
        s=np.array([list(state.s.values())]).reshape(1, -1).T,
        signal_state_names=eqs.signal_state_names,
        status=Status.SUCCESS,
        statistics=Statistics(0, None, 0, 0.0),
        evaluate=Evaluator(SimulationProblem(eqs, state.parameters, laws, scales), None),
        units=eqs.units,
        name=eqs.model.name,
        provenance=provenance_of(eqs, state.parameters, laws),
    )
