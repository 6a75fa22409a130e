"""Noises of estimators from one's own log: found on one part of it, judged on the other."""
