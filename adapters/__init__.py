"""Solvers behind the ports: a folder for each port, in it a file or folder for each solver."""
