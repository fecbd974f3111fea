"""Pictures of a robustness map: self-contained HTML and headless PNG. No physics here."""
