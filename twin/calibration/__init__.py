"""From a log to the machine and the soil that explain it, with what the log cannot tell said.

log -> segments or steady rows -> residuals of a forward model -> fit -> posterior -> verdicts, files
"""
