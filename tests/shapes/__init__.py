"""Shapes of grains."""
