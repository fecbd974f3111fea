"""Many scenes: one question to each, in processes of their own, and the answers as tables in a folder."""
