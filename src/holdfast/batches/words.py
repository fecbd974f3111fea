"""The words of a worker and its keeper: how a scene may end, and what they send each other."""

from __future__ import annotations

READY, PART, DONE = "ready", "part", "done"  # messages of a worker, beside the outcomes below
ANSWERED, ERROR, TIME, MEMORY, CRASH = "answered", "error", "time", "memory", "crash"  # outcomes of a scene
OUTCOMES = (ANSWERED, ERROR, TIME, MEMORY, CRASH)
MEGABYTE = 1 << 20
