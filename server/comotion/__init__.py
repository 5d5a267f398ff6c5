"""The command line: it knows both sides."""
