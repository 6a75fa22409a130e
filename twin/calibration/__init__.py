"""From a log to a machine and a soil: what it tells of them, and what it cannot tell."""
