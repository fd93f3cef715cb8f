"""Design studies: from a question to a measured best setting."""
