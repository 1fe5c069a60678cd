"""The interface's process with a defect: three seconds after its start its loop hangs, busy."""

from __future__ import annotations

import sys
import threading
import time

from aos_gcs.mission.events import Subscribers
from aos_gcs.mission.model.events import Event
from aos_gcs.runtime.dashboard.process import main

AFTER_S = 3.0


def hand_out_and_spin(self: Subscribers, event: Event) -> None:
    """Spin when the next event comes."""
    del self, event
    while True:
        pass


def spoil() -> None:
    """Spoil the program after some time."""
    time.sleep(AFTER_S)
    Subscribers.hand_out = hand_out_and_spin  # type: ignore[method-assign]


if __name__ == "__main__":
    threading.Thread(target=spoil, daemon=True).start()
    main(sys.argv[1:])
