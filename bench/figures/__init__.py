"""Numbers and tables of the pages, made from saved results."""
