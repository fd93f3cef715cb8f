"""Hard cases: what is expected of them, whether it is met, and the map of what stays stable.

Start with ``expected.py`` (what a case promises); docs/theory/benchmarks.md has all of them.
"""
