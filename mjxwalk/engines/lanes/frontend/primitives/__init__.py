"""What the interpreter does for each primitive of JAX."""
