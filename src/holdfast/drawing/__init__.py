"""Pictures of a robustness map as self-contained HTML pages and as PNG files; there is no physics here."""
