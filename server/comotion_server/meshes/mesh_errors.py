"""What can be wrong with a mesh that a user gives."""


class MeshError(ValueError):
    """A mesh that cannot be used; the message says why in one line, without the name of its file."""
