"""What a log shows of its own faults: values that cannot be, and quantities that disagree."""
