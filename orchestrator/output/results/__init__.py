"""The results of a run for the designer of a screen: pure functions of the run's folder, without a solver.

Start with ``compute.py``, which gathers the results; docs/theory/screening.md defines every figure.
"""
