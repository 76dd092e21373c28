"""A run as it evolves: a page that is served meanwhile, and figures for TensorBoard."""
