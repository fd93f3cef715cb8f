"""A scene in numbers, and what an effect is: what ``orchestrator/preflight/effects`` judges by."""
