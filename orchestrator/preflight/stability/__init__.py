"""Stability before the run: how long a sync interval may be, bound by bound.

Start with ``report.py``; derivations, tests and measured limits: docs/theory/stability.md.
"""
