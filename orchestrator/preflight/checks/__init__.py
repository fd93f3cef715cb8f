"""Rules of a case, each with its own test, by what they are about."""
