"""The page docs/commands.md, made from the commands of the program."""
