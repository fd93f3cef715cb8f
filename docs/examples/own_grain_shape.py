"""Your own shape of grains: a case lists its spheres; volume, inertia and sieve size are computed.

Two spheres that touch fall freely for 50 ms.  A sieve size of 20 mm is the diameter of each of them, because
on end they pass an opening of that size.

    python own_grain_shape.py [FOLDER]        # a new temporary folder by default
"""

import sys
import tempfile
from pathlib import Path

import flipflow

out = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())
case = flipflow.load("ball-on-panel", "draft").change(
    {
        "bed.shapes.twin.spheres": [[0, 0, -1, 1], [0, 0, 1, 1]],  # place and radius, in any unit
        "bed.particles.ball.shape": "twin",
        "particles.rolling": "none",  # it stands for the edges of spheres
        "duration_s": 0.05,
        "output.pictures": False,
    }
)
assert case.check() == []
run = case.run(out / "run")

print("mass / kg:", run.summary["material"]["fed"]["mass_kg"])
print("speed / (m/s):", run.history("probes/ball")["velocity_m_per_s.z"].iloc[-1])
