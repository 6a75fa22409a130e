"""Maps over the ground: heights, and shares of another soil; made from a seed or read from a file.

`maps` says what a scenario's ground needs, `random` makes it, `files` reads a user's own, `place`
puts it into a model.
"""
