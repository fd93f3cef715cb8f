"""The steps that make one checked ``Case`` of case.toml, a level and --set."""
