"""Proposals for new cases: complete, commented case folders from a few wishes (docs/theory/machine.md)."""
