"""What robots do with the answers: placing, transporting, taking apart."""
