"""The tables of results in docs/run-folder.md, made from their records."""
