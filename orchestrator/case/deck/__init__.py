"""Where panels, openings and triangles are."""
