"""The orchestrator of flipflow; ARCHITECTURE.md shows its rooms and what each is for."""
