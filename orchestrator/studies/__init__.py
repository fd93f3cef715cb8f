"""Many runs, and what they say together.

A study is a list of points, each run once whatever happens (``points.py``), whose numbers
(``quantities.py``) are judged by criteria (``criteria.py``, ``verdicts.py``) or become tables, pictures
and a page (``report.py``).  Every module of ``commands`` is a command of ``flipflow study``, found by
its name: ``command`` is a generator that yields what is to be said (lines, tables, files that were
written) and returns whether all is well; ``options.py`` makes its options.
"""
