"""A case: its tables, the files it is read from, its deck and bed, and the plans that solvers need.

Nothing here judges physics or knows a solver; what is above asks this room what the user described.
"""
