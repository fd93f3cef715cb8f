"""The particles: their sizes, their feed, their contacts and the record of their whereabouts."""
