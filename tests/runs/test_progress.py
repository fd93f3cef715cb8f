"""The progress of a run that goes on from a checkpoint."""

from __future__ import annotations

import json
import time

import pytest

from orchestrator.run.progress import Progress


def test_a_resumed_run_goes_on_counting_its_time() -> None:
    """The time goes on in the whole, by part, that of the processor, and what is repeated."""
    stopped = Progress()
    stopped.stopwatch.wall_s |= {"panel": 3.0, "coupling": 1.0}
    stopped.stopwatch.repeated_s |= {"panel": 1.5}
    stopped.figures["particles"] = 10
    stopped.count_sync_point(4, 0.25, 7)
    saved = json.loads(json.dumps(stopped.as_json())) | {"processor_s": 50.0, "processor_before_s": 2.0}
    resumed = Progress()
    resumed.stopwatch.wall_s["panel"] = 0.5
    resumed.restore(saved)
    assert resumed.stopwatch.wall_s == {"panel": 3.5, "coupling": 1.0}
    assert resumed.stopwatch.repeated_s == {"panel": 1.5}
    assert (resumed.done, resumed.simulated_s, resumed.particle_steps) == (4, 0.25, 70)
    assert resumed.wall_s >= saved["wall_s"]
    assert 50.0 < resumed.processor_s == pytest.approx(50.0 + time.process_time(), abs=0.1)
    assert 2.0 < resumed.processor_before_s == pytest.approx(2.0 + Progress().processor_before_s, abs=0.1)
