"""NMEA 0183 sentences for tests."""

from __future__ import annotations


def checksum(body: str) -> int:
    """Exclusive or of the characters between `$` and `*`."""
    total = 0
    for character in body.encode("ascii"):
        total ^= character
    return total


def sentence(body: str) -> str:
    """A body with its dollar sign and its checksum."""
    return f"${body}*{checksum(body):02X}"
