"""One module per command: `NAME`, `add_to` (its options and help) and `execute`."""
