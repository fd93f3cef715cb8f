"""What accuracy costs: ``flipflow study accuracy``, and ``flipflow plan``, which uses its findings.

``refinement.py`` has the parameters, ``study.py`` the order in which points are run.
"""
