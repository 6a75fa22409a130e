"""What the twin is checked against, from closed forms to a real tractor's log.

Each module is a layer: functions that measure and return checks. `suite` runs them, `page` writes
them down.
"""
