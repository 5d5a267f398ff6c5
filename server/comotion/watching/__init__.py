"""What `comotion watch` shows: a running server or a recorded run, in a browser or in the terminal (docs/watch.md)."""
