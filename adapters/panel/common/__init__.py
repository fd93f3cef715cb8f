"""What panels of several solvers are made of."""
