"""Files: whole or not at all; dataclasses as plain values; run folders; rows of results."""
