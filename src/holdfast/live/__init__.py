"""The live view: a page that turns, asks and edits, served to this machine alone."""
