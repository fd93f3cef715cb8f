"""A figure for a paper: the hysteresis loop of a rubber bushing, one column wide, with its data beside it.

python figure_for_a_paper.py [FOLDER]        # a new temporary folder by default
"""

import math
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import flipflow

COLUMN_MM = 84

out = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())
speed_rad_per_s = 25 * math.pi  # a cycle of 80 ms is a whole number of sync intervals
case = flipflow.load("bushing-hysteresis").change(
    {"screen.frames.plate.drive.speed_rad_per_s": speed_rad_per_s, "output.pictures": False}
)
run = case.run(out / "run")
assert run.is_trusted, run.doubts

loop = run.history("bushings/rubber")[["deformation_m.x", "force_N.x"]]
loop = loop[loop.index > loop.index[-1] - 1.001 * 2 * math.pi / speed_rad_per_s]
loop.to_csv(out / "loop.csv")
x_m, force_N = loop["deformation_m.x"].to_numpy(), loop["force_N.x"].to_numpy()
lost_J = np.sum((force_N[1:] + force_N[:-1]) / 2 * np.diff(x_m))

plt.rcParams.update({"font.size": 8, "axes.linewidth": 0.6, "pdf.fonttype": 42})  # letters stay letters
fig, axes = plt.subplots(figsize=(COLUMN_MM / 25.4, 0.7 * COLUMN_MM / 25.4), layout="constrained")
axes.plot(1e3 * x_m, 1e-3 * force_N, color="black", linewidth=0.8)
axes.set(xlabel="deformation / mm", ylabel="force / kN")
axes.annotate(f"{lost_J:.2f} J in a cycle", (0.05, 0.9), xycoords="axes fraction")
fig.savefig(out / "loop.pdf")
fig.savefig(out / "loop.png", dpi=300)
