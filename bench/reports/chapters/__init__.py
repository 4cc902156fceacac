"""What pages tell of records: sections of texts, tables and plots, one module for each kind of record or table."""
