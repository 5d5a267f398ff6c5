"""The lowest floor: compiled loops over plain arrays. They never raise and import nothing from above."""
