"""One run from a scenario, or a log, to streams, truth, estimates and scores."""
