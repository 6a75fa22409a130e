"""From a scenario to a machine on soil, and from there to its trajectory."""
