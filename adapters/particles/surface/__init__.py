"""The surface of triangles as particles meet it, for any solver."""
