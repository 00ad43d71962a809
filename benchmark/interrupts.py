"""Ctrl-C within a suite: a method that answers it with its best plan must not hide it from the suite."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType


@dataclass(slots=True)
class Interrupts:
    """Whether Ctrl-C was pressed."""

    seen: bool = False

    def raise_if_seen(self) -> None:
        """Raise ``KeyboardInterrupt`` again when somebody took the first one."""
        if self.seen:
            raise KeyboardInterrupt


@contextmanager
def noted_interrupts() -> Iterator[Interrupts]:
    """Note Ctrl-C while the context lasts, and raise ``KeyboardInterrupt`` as ever; main thread only."""
    interrupts = Interrupts()

    def note(number: int, frame: FrameType | None) -> None:
        interrupts.seen = True
        raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield interrupts
        return
    before = signal.signal(signal.SIGINT, note)
    try:
        yield interrupts
    finally:
        signal.signal(signal.SIGINT, before)
