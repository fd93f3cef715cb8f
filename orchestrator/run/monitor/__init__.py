"""The watch on the coupling: what a run looks at while it goes on, and what it does about it."""
