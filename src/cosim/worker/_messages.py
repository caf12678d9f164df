"""Messages over a pipe: their length, then their bytes."""

from __future__ import annotations

import os

_HEAD = 8
_PIECE = 2**16


def send(channel: int, content: bytes) -> None:
    """Write a message."""
    left = memoryview(len(content).to_bytes(_HEAD, "little") + content)
    while left:
        left = left[os.write(channel, left) :]


def receive(channel: int) -> bytes | None:
    """Wait for a message and return it; None if there comes none any more."""
    message = Message()
    while message.content is None:
        if not message.take(channel):
            return None
    return message.content


class Message:
    """A message of which parts may have come: ``content`` is None until all of it is there."""

    def __init__(self) -> None:
        """Nothing has come yet."""
        self._bytes = b""
        self.content: bytes | None = None

    def take(self, channel: int) -> bool:
        """Read what is there, waiting if it is nothing; False if the channel has ended."""
        missing = _HEAD - len(self._bytes)
        if missing <= 0:
            missing = _HEAD + int.from_bytes(self._bytes[:_HEAD], "little") - len(self._bytes)
        part = os.read(channel, min(missing, _PIECE))
        self._bytes += part
        head, body = self._bytes[:_HEAD], self._bytes[_HEAD:]
        if len(head) == _HEAD and len(body) == int.from_bytes(head, "little"):
            self.content = body
        return bool(part)
