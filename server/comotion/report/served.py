"""A simulation behind the whole protocol, in memory: what a client meets but for the network."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from comotion_protocol import MotionClient
from comotion_protocol.link import MemoryLink
from comotion_server.desk import Desk
from comotion_server.service import Service

if TYPE_CHECKING:
    from comotion_server.simulation import Simulation

RUN = "report"


@contextmanager
def served(simulation: "Simulation", **wanted: Any) -> Iterator[MotionClient]:
    """An open session."""
    with Desk(Service(simulation, RUN)) as desk:
        link = MemoryLink(desk)
        try:
            with MotionClient.open(RUN, link=link, **wanted) as motion:
                yield motion
        finally:
            link.close()
