"""The monitor of a run: what it looks at while the run goes on, and what it does about it."""
