"""``flipflow ladder``: a case on every rung of each solver's ladder, measured."""
