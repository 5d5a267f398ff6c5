"""The response to a pair that collides (P11 to P13): one impulse, its books, and new flights for both bodies."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from comotion_server.kernels.books import carried, errors, size_of, taken
from comotion_server.kernels.flight import begin
from comotion_server.kernels.impact import impulse_of, push
from comotion_server.results import Books, Impact
from comotion_server.world import World

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Touch:
    """Where and how a pair collides: rows of the bodies, a point on each, the unit normal from a to b, world frame."""

    a: int
    b: int
    point_a: Array
    point_b: Array
    normal: Array

    def at_midpoint(self) -> "Touch":
        """The same with both points midway: bodies that intersect must get opposite impulses in one line."""
        middle = 0.5 * (self.point_a + self.point_b)
        return Touch(self.a, self.b, middle, middle, self.normal)


@dataclass(slots=True)
class Ledger:
    """The impacts of a step as they happen."""

    impacts: list[Impact] = field(default_factory=list)
    contacts: dict[tuple[int, int], tuple[Array, int]] = field(default_factory=dict)
    books: Books = field(default_factory=Books)


def respond(
    world: World, ledger: Ledger, touch: Touch, local_time: float, start_time: float, *, parallel: bool
) -> bool:
    """Applies the impulse of one touch at `local_time` of a step that began at `start_time` [s]; whether there was one.

    A `parallel` contact pushes without turning (P12).
    """
    a, b, p, q, n = touch.a, touch.b, touch.point_a, touch.point_b, touch.normal
    x, v, R, L, w = world.state.arrays
    bodies, scene = world.bodies, world.scene
    e = scene.collisions.restitution_between(scene.bodies[a], scene.bodies[b])
    impulse, speed, ease, turning = impulse_of(bodies, a, b, x, v, R, w, p, q, n, e, parallel)
    if impulse <= 0.0:
        return False
    J = impulse * n
    before, after, given, scale = np.zeros(7), np.zeros(7), np.zeros(7), np.zeros(3)
    for i, point, side in ((a, p, -J), (b, q, J)):
        carried(bodies, i, x, v, L, w, q, before)
        taken(bodies, i, x, v, w, q, side, turning, given)
        sizes = size_of(bodies, i, x, v, L, q)
        scale[:2] += sizes
        push(bodies, i, x, v, R, L, w, point, side, turning)
        carried(bodies, i, x, v, L, w, q, after)
        if bodies.reacts[i]:
            begin(world.flights, bodies, i, local_time, x[i], v[i], R[i], L[i], w[i])
    loss = 0.5 * (1.0 - e * e) * speed * speed / ease
    given[6] -= loss
    scale += (
        impulse,
        impulse * float(np.linalg.norm(q - x[b]) + np.linalg.norm(p - x[a])),
        before[6] + 0.5 * speed**2 / ease,
    )
    _record(ledger, touch, J, given, before, after, scale)
    names = world.names
    law = "ordinary" if turning else "parallel"
    ledger.impacts.append(
        Impact(start_time + local_time, names[a], names[b], q.copy(), n.copy(), impulse, speed, e, law)
    )
    return True


def _record(ledger: Ledger, touch: Touch, J: Array, given: Array, before: Array, after: Array, scale: Array) -> None:
    """Closes the books of one impact and adds its impulse to the contacts of the step."""
    wrong = np.empty(3)
    errors(before, after, given, scale, wrong)
    books = ledger.books
    books.impacts += 1
    books.momentum = max(books.momentum, float(wrong[0]))
    books.angular_momentum = max(books.angular_momentum, float(wrong[1]))
    books.energy = max(books.energy, float(wrong[2]))
    total, count = ledger.contacts.get((touch.a, touch.b), (np.zeros(3), 0))
    ledger.contacts[touch.a, touch.b] = (total + J, count + 1)
