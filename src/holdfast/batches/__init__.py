"""Batches: one question about many scenes, answered in worker processes, with tables in a folder."""
