"""The course of runs in the formats of other benchmarks, so that what reads these reads ours."""
