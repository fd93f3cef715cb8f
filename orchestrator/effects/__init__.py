"""Which effects a scene calls for, by dimensionless numbers (docs/theory/effects.md)."""
