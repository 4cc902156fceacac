"""How things are timed side by side: processes that answer timing requests, rows, pairs, tables, pages."""
