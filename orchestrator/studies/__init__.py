"""Studies: many runs, and the conclusions from all of them together.

A study is a list of points, each of which is run once, whatever happens (``points.py``).  Criteria judge the
numbers of the runs (``quantities.py``, ``criteria.py``, ``verdicts.py``), or the numbers become tables,
pictures and a page (``report.py``).  Every module of ``commands`` is a command of ``flipflow study`` and has
the command's name.  Its function ``command`` is a generator: it yields lines, tables and written files for
the console and returns whether all is well.  ``options.py`` makes its options.
"""
