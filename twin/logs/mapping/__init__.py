"""A first column map of an unknown log, from the names of its signals and from physics."""
