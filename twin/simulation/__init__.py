"""A machine driven along its course: driver, course, ends, trajectory."""
