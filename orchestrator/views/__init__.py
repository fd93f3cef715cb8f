"""The views of a machine before it runs: drawings, modes, a page and a scene in three dimensions."""
