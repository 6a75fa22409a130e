"""What is found by name or by `module:Name`."""
