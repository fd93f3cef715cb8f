"""The page docs/materials.md, made from the library of materials."""
