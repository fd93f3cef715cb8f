"""Parts that the panels of several solvers share."""
