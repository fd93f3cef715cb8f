"""The regime of a mat: how it flips from turn to turn between the moving clamps of an empty machine."""
