"""The particles: sizes, feed, contacts, and the book of what came and went."""
