"""What is said of a case before it runs: its problems, the effects that it calls for, how long a
sync interval stays stable, and what the run will cost.

The case comes in as tables and leaves as it will be run, with reasons for all that was left out.
"""
