"""How benchmarks measure and report: processes, turns, comparisons of engines, growth, tables, figures."""
