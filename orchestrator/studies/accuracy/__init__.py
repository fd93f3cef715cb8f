"""The cost of accuracy: ``flipflow study accuracy``, and ``flipflow plan``, which uses its findings.

``refinement.py`` has the parameters, and ``study.py`` runs the points in their order.
"""
