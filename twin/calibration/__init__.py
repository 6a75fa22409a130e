"""From a log to the machine and the soil that explain it; what the log leaves open is named.

log -> segments or steady rows -> forward model -> fit -> posterior -> verdicts, holdout, files
"""
