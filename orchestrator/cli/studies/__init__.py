"""The commands of ``flipflow study``, one module each, which has the command's name.

Its function ``command`` is a generator: it yields lines, tables and written files for the console and returns
whether all is well.  ``cli/options.py`` makes its options.
"""
