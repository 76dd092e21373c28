"""Code from a program: LLVM IR and machine code of the host, or JAX operations."""
