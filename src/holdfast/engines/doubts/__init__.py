"""What every engine is told to doubt: contacts that may not exist, poses that are a little off, falls within reach."""
