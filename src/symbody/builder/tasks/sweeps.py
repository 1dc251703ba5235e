"""A sweep of one parameter with its curves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from symbody.builder.task_failure import Report
from symbody.builder.tasks.json_values import curve, finite
from symbody.builder.tasks.options import SweepOptions, read_options
from symbody.builder.tasks.reading import complete_model
from symbody.builder.tasks.simulation import PipeProgress
from symbody.equations.form import form_equations
from symbody.simulation.sweeps.sweep import sweep
from symbody.visual.scene.json_form import encode_array


def sweep_parameter(payload: Mapping[str, Any], report: Report) -> dict[str, Any]:
    """Return the curves of some outputs for several values of a parameter."""
    options = read_options(SweepOptions, payload["options"])
    eqs = form_equations(complete_model(payload["data"], payload["folder"]))
    outputs = options.outputs or list(eqs.coordinate_names[:6])
    report("compiling", None)
    motions = sweep(
        eqs,
        options.t_end,
        parameters={options.parameter: options.values},
        inputs=options.inputs,
        times=np.linspace(0.0, options.t_end, options.samples),
        progress=PipeProgress(report, "integrating"),
    )
    values = {name: motions[name] for name in outputs}
    return {
        "parameter": options.parameter,
        "unit": motions.units.get(options.parameter, ""),
        "times": encode_array(motions.t, "<f8"),
        "cases": [
            {
                "value": options.values[k],
                "status": status.name,
                "advice": "" if status.success else status.value,
                "reached": finite(motions.reached[k]),
                "curves": [curve(name, eqs.units.get(name, ""), array[k]) for name, array in values.items()],
            }
            for k, status in enumerate(motions.status)
        ],
        "notes": list(motions.notes),
    }
