"""What a user would write instead: the same maps in NumPy and in JAX."""
