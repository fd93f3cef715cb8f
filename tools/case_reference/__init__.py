"""The page docs/case-format.md, made from the tables of a case."""
