"""The library of named materials and their contacts, and its use in a case."""
