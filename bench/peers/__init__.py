"""The same maps in NumPy and in JAX, as a user would write them."""
