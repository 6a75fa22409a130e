"""The truth an estimate is scored against, from a trajectory."""
