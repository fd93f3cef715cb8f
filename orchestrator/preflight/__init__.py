"""The examination of a case before it runs.

It finds the problems of a case and the effects that matter in it, bounds the sync interval, and
estimates the cost of the run.  A case comes in as tables and leaves as it will be run, with a
reason for everything that is left out.
"""
