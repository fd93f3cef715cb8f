#!/bin/bash
# A run that is stopped and goes on: the result is bit for bit that of a run without interruption.
#
# Ctrl-C does the same as the signal here. "flipflow resume" goes on after a crash or a kill, too, from the last
# checkpoint.
#
#     bash resume.sh [FOLDER]        # a new temporary folder by default
set -euo pipefail
out=${1:-$(mktemp -d)}

case=(empty-machine --level draft --set duration_s=0.24 --set checkpoint.every_s=0.02 --set output.pictures=false)
flipflow run "${case[@]}" --out "$out/whole"

flipflow run "${case[@]}" --out "$out/stopped" &
until compgen -G "$out/stopped/checkpoints/*/checkpoint.json" > /dev/null; do sleep 0.05; done
kill -TERM $!
wait $! || echo "stopped with exit code $?"
flipflow resume "$out/stopped"

diff -r "$out/whole/surface" "$out/stopped/surface" && echo "the same surface, bit for bit"
