"""How benchmarks measure and report: processes, turns, growth of errors, tables, figures."""
