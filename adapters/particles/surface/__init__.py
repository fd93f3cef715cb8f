"""The surface of triangles as spheres meet it: nearest features, smooth patches, its turning."""
