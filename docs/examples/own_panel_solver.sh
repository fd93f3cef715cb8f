#!/bin/bash
# Your own panel solver: a package beside flipflow brings it, and a case names it.
#
# The solver is the one of docs/how-to/add-a-solver.md, a mass on springs; it is taken from that page. pip makes
# the folder springs-1.0.dist-info from the pyproject.toml of your package; here two lines write it, so that no
# network is needed.
#
#     bash own_panel_solver.sh [FOLDER]        # a new temporary folder by default
set -euo pipefail
page=$(cd "$(dirname "$0")" && pwd)/../how-to/add-a-solver.md
out=${1:-$(mktemp -d)}

mkdir -p "$out/package/springs-1.0.dist-info"
sed -n '/^```python$/,/^```$/p' "$page" | sed '/^```/d' > "$out/package/springs.py"
printf 'Metadata-Version: 2.1\nName: springs\nVersion: 1.0\n' > "$out/package/springs-1.0.dist-info/METADATA"
printf '[flipflow.panel]\nsprings = springs:ADAPTER\n' > "$out/package/springs-1.0.dist-info/entry_points.txt"
export PYTHONPATH="$out/package"

case=(empty-machine --level draft --set panel.solver=springs --set duration_s=0.08 --set output.pictures=false)
flipflow check "${case[@]}"
flipflow run "${case[@]}" --out "$out/run"
