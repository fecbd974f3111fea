"""One thread that computes for the window; long jobs are interrupted by other requests."""

from __future__ import annotations

import threading
from collections.abc import Callable

from holdfast.base.errors import HoldfastError
from holdfast.base.progress import listening

Job = Callable[[], None]
Listener = Callable[[str], None]


class GaveWayError(Exception):
    """Stops a long computation between two of its reports, because of another request."""


class Worker:
    """Does jobs one after the other in a thread of its own.

    A waiting job is replaced by a newer one with the same name. A ``patient`` job is interrupted by any other request,
    and starts again when no other job waits. ``on_progress`` is called with the progress of jobs; "" means that a job
    is done. ``on_failure`` is called with the text of a HoldfastError, which ends only its own job.
    """

    def __init__(self, on_progress: Listener, on_failure: Listener) -> None:
        self._on_progress, self._on_failure = on_progress, on_failure
        self._waiting: dict[str, tuple[Job, bool]] = {}
        self._change = threading.Condition()
        self._busy = False
        self._closed = False
        self._thread = threading.Thread(target=self._run, name="holdfast view", daemon=True)
        self._thread.start()

    def ask(self, name: str, job: Job, *, patient: bool = False) -> None:
        """Add a job."""
        with self._change:
            self._waiting.pop(name, None)
            self._waiting[name] = (job, patient)
            self._change.notify_all()

    def rest(self, timeout: float = 60.0) -> bool:
        """Wait until no job is left, at most ``timeout`` [s]; return whether none is left."""
        with self._change:
            return self._change.wait_for(lambda: not self._waiting and not self._busy, timeout)

    def close(self) -> None:
        """Stop; a job that runs ends at its next report."""
        with self._change:
            self._closed = True
            self._change.notify_all()
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout=10.0)

    def _run(self) -> None:
        while True:
            with self._change:
                self._busy = False
                self._change.notify_all()
                self._change.wait_for(lambda: self._closed or bool(self._waiting))
                if self._closed:
                    return
                urgent = (name for name, (_, patient) in self._waiting.items() if not patient)
                name = next(urgent, next(iter(self._waiting)))
                job, patient = self._waiting.pop(name)
                self._busy = True
            self._do(name, job, patient)

    def _do(self, name: str, job: Job, patient: bool) -> None:
        def listener(stage: str, done: int, total: int) -> None:
            if self._closed or (patient and self._waiting):
                raise GaveWayError
            self._on_progress(f"{stage}: {done} of {total}" if total else stage)

        try:
            with listening(listener):
                job()
        except GaveWayError:
            with self._change:
                self._waiting.setdefault(name, (job, patient))
            return
        except HoldfastError as error:
            self._on_failure(f"{name}: {error}")
        self._on_progress("")
