#!/bin/bash
# A study as jobs of a cluster: a list of commands and an array for Slurm, and the tables when the jobs are done.
#
# Here the tasks are executed one after another; on a cluster the loop is "sbatch FOLDER/speeds/job.sh". The
# folder must be on a file system that all nodes share.
#
#     bash cluster_job.sh [FOLDER]        # a new temporary folder by default
set -euo pipefail
out=${1:-$(mktemp -d)}

sweep=(flipflow study sweep bushing-hysteresis --out "$out/speeds" --workers 1
    --vary screen.frames.plate.drive.speed_rad_per_s=40,80 --set duration_s=0.4 --set output.pictures=false)
"${sweep[@]}" --write-jobs

for task in $(seq "$(wc -l < "$out/speeds/jobs.txt")"); do
    SLURM_ARRAY_TASK_ID=$task bash "$out/speeds/job.sh"
done

"${sweep[@]}"        # finds the runs done, and writes sweep.csv and sweep.png
