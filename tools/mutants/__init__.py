"""Mistakes that are put into the code to see whether a test catches them."""
