"""Objects that are found by their name or by `module:Name`, such as estimators."""
