"""What accuracy costs: ``flipflow study accuracy``, and ``flipflow plan``, which uses its findings.

``knobs.py`` has what may be turned, ``study.py`` the order in which points are run.
"""
