"""From a Python function to the scalar graph: JAX traces it, an interpreter unrolls it."""
