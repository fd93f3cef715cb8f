"""Results that a screen's designer wants, from the folder of a run: pure functions, no solver.

Start with ``compute.py``, which gathers them; docs/theory/screening.md defines every figure.
"""
