"""Studies: many runs, and the conclusions from all of them together.

A study is a list of points, each of which is run once, whatever happens (``points.py``).  Criteria judge the
numbers of the runs (``criteria.py``, ``verdicts.py``), or the numbers become tables, pictures and a page.  Of
the rest of the program, studies know the workbench alone (``orchestrator/workbench``).  Their commands are in
``orchestrator/cli/studies``.
"""
