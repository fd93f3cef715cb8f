"""A case: its tables, the files it is read from, its deck and bed, and the plans that solvers need.

Nothing here judges physics; the rooms above ask this one what the user has described.
"""
