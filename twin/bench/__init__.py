"""Speed and memory of this program on a machine."""
