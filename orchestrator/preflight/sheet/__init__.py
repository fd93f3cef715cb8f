"""The designer's sheet: what the rules of handbooks say about a machine before any run."""
