"""Running kernels for all walkers."""
