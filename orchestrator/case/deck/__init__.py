"""The geometry of the deck: its panels, openings, rigid surfaces and triangles."""
