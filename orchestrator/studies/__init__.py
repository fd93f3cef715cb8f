"""Many runs, and what they say together.

A study is a list of points (``points.py``), each run once whatever happens (``workers.py``), whose
results become tables, pictures and a page (``tables.py``).  Every module of ``commands`` is a
command of ``flipflow study``, found by its name: ``command`` is a generator that yields what is to
be said (lines, tables, files that were written) and returns whether all is well.
"""
