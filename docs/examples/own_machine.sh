#!/bin/bash
# Your own machine: proposed from a width, a material and a stroke, and run.
#
# The run is empty and short, so that it takes seconds; "flipflow run FOLDER/mine" is the draft with limestone, some
# eight minutes, and "flipflow show FOLDER/mine" draws the machine. The end of the run prints the stroke, to be
# compared with the 6 mm that are asked for.
#
#     bash own_machine.sh [FOLDER]        # a new temporary folder by default
set -euo pipefail
out=${1:-$(mktemp -d)}

flipflow new "$out/mine" --panels 4 --width "2 m" --opening "12 mm" --stroke "6 mm" --speed "750 rpm" \
    --material limestone --throughput "50 t/h" --feed "0-30 mm" --yes

empty=(--set particles.solver=none --set duration_s=0.48 --set output.pictures=false)
flipflow run "$out/mine" "${empty[@]}" --set coupling.sync_interval_s=2e-4 --out "$out/run"
