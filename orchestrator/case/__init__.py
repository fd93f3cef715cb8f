"""The case: its tables, the files that it is read from, its deck and bed, and the plans for solvers.

Nothing here judges the physics: the packages above this one ask it what the user has described.
"""
