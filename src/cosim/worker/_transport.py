"""What a worker's parent needs of the way it was started."""

from __future__ import annotations

from typing import Protocol

from cosim.worker._death import Death


class Transport(Protocol):
    """How a worker is started and heard of, which depends on the system."""

    @property
    def answer(self) -> bytes | None: ...

    @property
    def death(self) -> Death | None: ...

    def send(self, content: bytes) -> None: ...

    def wait(self, seconds: float) -> None: ...

    def kill(self) -> None: ...

    def close(self) -> None: ...
