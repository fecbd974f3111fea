"""A fuzzer: seeded random scenes, files and names, each tried in a process with limits of time and memory.

``python -m fuzz`` (``make fuzz``) runs it, ``test_fuzz`` a little of it, and ``test_found`` tries again what it found.

- ``scenes``, ``files`` and ``names`` draw inputs: plain data, from a seed, a kind and a number alone.
- ``trials`` tries one input and ``judge`` compares the answers; ``worker`` does so in a process of its own, which
  ``keeper`` starts, times and replaces.
- ``shrink`` makes what failed smaller, ``store`` keeps it together with the counts, ``campaign`` is the whole run.
"""
