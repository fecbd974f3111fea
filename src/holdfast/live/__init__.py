"""The live view: an interactive page to view, push and edit a scene, for this machine only."""
