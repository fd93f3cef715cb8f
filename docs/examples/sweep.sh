#!/bin/bash
# A sweep: how hard a mat pulls at its clamps, over its thickness.
#
# One panel hangs between a fixed clamp and one that moves to and fro. The folder gets a run for each thickness,
# sweep.csv with all results, and pictures. Called again, the command makes only the runs that are missing.
#
#     bash sweep.sh [FOLDER]        # a new temporary folder by default
set -euo pipefail
out=${1:-$(mktemp -d)}

flipflow study sweep panel-cycle --level draft --out "$out/thickness" --workers 1 \
    --vary "screen.panels.deck.thickness_m=3 mm,4 mm,5 mm" --result tension --result stretch \
    --set duration_s=0.32 --set output.pictures=false
