"""Your own sieve curve: a block of coal has the sizes of a laboratory's table, and the run is sieved again.

python own_sieve_curve.py [FOLDER]        # a new temporary folder by default
"""

import shutil
import sys
import tempfile
from pathlib import Path

import pandas

import flipflow

LAB = """sieve / mm;passing / %
20;100
16;85
12,5;40
10;10
8;0
"""

out = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())
shutil.copytree(flipflow.load("quickstart").folder, out / "coal")  # a table stands in the folder of its case
(out / "coal/lab.csv").write_text(LAB, encoding="utf-8")

case = flipflow.load(out / "coal", "draft").change(
    {
        "bed.blocks.coal.curve.file": "lab.csv",
        "bed.blocks.coal.count": 1000,
        "duration_s": 0.01,
        "output.pictures": False,
    }
)
assert case.check() == []
run = case.run(out / "run")

size_mm = 1e3 * run.history("fed")["sieve_size_m"].to_numpy()  # of each particle
mass = size_mm**3
table = pandas.read_csv(out / "coal/lab.csv", sep=";", decimal=",")
table["run / %"] = [100 * mass[size_mm <= sieve].sum() / mass.sum() for sieve in table["sieve / mm"]]
table.to_csv(out / "sieved.csv", index=False)
print(table)
