"""From poses to vertices: always R X + x from the reference shape, never incremental (P3)."""

from comotion_server.kernels.jit import jit


@jit
def place(reference, rotation, position, vertices):
    """World vertices (n,3) of one body from its reference vertices (n,3) about the centre of mass, body frame."""
    for i in range(reference.shape[0]):
        x, y, z = reference[i, 0], reference[i, 1], reference[i, 2]
        for k in range(3):
            vertices[i, k] = rotation[k, 0] * x + rotation[k, 1] * y + rotation[k, 2] * z + position[k]


@jit
def place_velocities(reference, rotation, velocity, spin, velocities):
    """World velocities v + w x (R X) (n,3) [m/s] of one body's vertices; `spin` is its angular velocity w (3,)."""
    for i in range(reference.shape[0]):
        x, y, z = reference[i, 0], reference[i, 1], reference[i, 2]
        rx = rotation[0, 0] * x + rotation[0, 1] * y + rotation[0, 2] * z
        ry = rotation[1, 0] * x + rotation[1, 1] * y + rotation[1, 2] * z
        rz = rotation[2, 0] * x + rotation[2, 1] * y + rotation[2, 2] * z
        velocities[i, 0] = velocity[0] + spin[1] * rz - spin[2] * ry
        velocities[i, 1] = velocity[1] + spin[2] * rx - spin[0] * rz
        velocities[i, 2] = velocity[2] + spin[0] * ry - spin[1] * rx
