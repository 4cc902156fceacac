"""The groups of rows by name. They name tasks and import none, so that listing them costs nothing."""
