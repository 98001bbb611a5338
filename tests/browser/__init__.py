"""Pages in a real browser: ``python -m tests.browser`` (needs chromium, and ``pip install '.[browser]'``)."""
