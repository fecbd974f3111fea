"""What every floor stands on: errors, arrays, rigid motions, files, progress."""
