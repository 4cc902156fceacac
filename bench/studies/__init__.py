"""What a run can be: an identification, or another question asked of a problem and its measurement."""
