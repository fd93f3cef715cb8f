"""From case.toml, a level and --set to one checked ``Case``."""
