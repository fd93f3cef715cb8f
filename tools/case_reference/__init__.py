"""The pages docs/case-format.md and docs/study-format.md, made from the tables of a case and of a study."""
