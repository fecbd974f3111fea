"""Small motions that bring bodies to rest near given poses. This package knows no engine and no verdict."""
