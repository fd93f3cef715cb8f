"""Finite-element panels: meshes, forms and time steps of ``sheet`` and ``solid``."""
