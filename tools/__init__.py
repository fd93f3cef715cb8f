"""Tools of flipflow's developers: commands that measure the program, and are no tests of it."""
