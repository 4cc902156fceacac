"""Studies: an identification, or another question to a problem and its measurement."""
