"""Noises of estimators from your own log: found on one part of it, judged on the other."""
