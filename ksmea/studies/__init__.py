"""Studies: one question about a problem each, answered as a typed record."""
