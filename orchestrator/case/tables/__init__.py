"""The tables of a case file, as pydantic models."""
