"""The benchmark: experiments as Hydra configurations, plans of runs, records, tables and figures."""
