"""A scene in numbers, and what an effect is: from what ``orchestrator/effects`` judges."""
