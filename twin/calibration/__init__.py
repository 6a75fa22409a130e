"""From a log to the machine and the soil that explain it, with what the log cannot tell said.

log -> segments or steady rows -> forward model -> fit -> posterior -> verdicts, holdout, files
"""
