"""From a scenario to a compiled machine with its parameter block."""
