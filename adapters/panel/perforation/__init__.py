"""Panels with openings as if they were whole: unit cells and what they give."""
