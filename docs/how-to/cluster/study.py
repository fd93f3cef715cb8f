"""A Dask scheduler whose workers are jobs of Slurm: the runs of a study then go to the cluster.

Start it on a login node, in the environment of flipflow, with ``pip install dask-jobqueue`` added:

    python study.py 10 &
    flipflow study sweep CASE --vary ... --scheduler "$(cat scheduler-address)"
"""

import sys
import time
from pathlib import Path

from dask_jobqueue import SLURMCluster

jobs = int(sys.argv[1]) if len(sys.argv) > 1 else 4
cluster = SLURMCluster(
    cores=1,  # a run has one process
    processes=1,
    memory="4GB",
    walltime="24:00:00",
    # queue="normal", account="...",   as your cluster wants it
    worker_extra_args=["--lifetime", "23h"],
    job_extra_directives=["--job-name=flipflow-study"],
)
cluster.scale(jobs=jobs)
Path("scheduler-address").write_text(cluster.scheduler_address)
print(f"{jobs} jobs were asked for; the scheduler is {cluster.scheduler_address}", flush=True)
while True:  # the workers live as long as this program
    time.sleep(60)
