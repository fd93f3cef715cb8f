"""The figures of a run's results: typed tables in which each figure has one record.

A record says what a figure is, its resolution, whether a slice has its share of it, to which part of the
machine it belongs, whether it decides, and in which unit people read it.  Its path in ``summary.json`` and
its unit follow from its place and its name.  All readers of results, and docs/run-folder.md, take them from
here.
"""
