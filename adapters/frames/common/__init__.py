"""What frames of several solvers are made of."""
