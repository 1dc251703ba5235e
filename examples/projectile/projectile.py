"""A thrown body: in a plane, and free in space; both fly alike."""

from pathlib import Path

import symbody as sb

folder = Path(__file__).parent
for name in ("projectile", "projectile_free"):
    eqs = sb.form_equations(sb.load_model(folder / f"{name}.toml"))
    print(eqs.coordinate_names)
    run = sb.simulate(eqs, 1.0, times=[0, 0.5, 1])
    print(f"apex {run['Y'][1]:.6f} m, lands at X = {run['X'][2]:.6f} m, turned by {run['theta'][2]:.6f} rad")
