"""MuJoCo: scenes from MJCF files and from running simulations, and MJCF files from scenes.

``reader`` reads files, ``mjcf_guard`` refuses hostile files before MuJoCo reads them, and ``live`` makes a scene of a
compiled model and its state, with ``mobility`` (which bodies move) and ``rules`` (which geoms may touch, with which
friction). ``writer`` writes MJCF files.
"""
