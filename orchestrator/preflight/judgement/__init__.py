"""Which effects matter in a case: the catalogue of them, and their verdicts weighed together."""
