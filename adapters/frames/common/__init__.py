"""Parts that the frames of several solvers share."""
