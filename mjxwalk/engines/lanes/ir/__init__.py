"""The scalar graph, its simplification, and the order in which a kernel computes it."""
