"""More room for what the event queue remembers: pairs, contact points of a cluster, the log of impacts."""

from typing import Any

import numpy as np

from comotion_server.kernels import event_queue as events
from comotion_server.kernels.event_heap import Heap
from comotion_server.kernels.event_scene import Gathered, Queue
from comotion_server.kernels.mesh_room import Directions, PatchPoints, PatchWork
from comotion_server.kernels.pair_memory import Pairs, new_pairs


def enlarged(queue: Queue, code: int) -> Queue:
    """The same queue with twice the room for what `play` ran out of."""
    if code == events.LOG_FULL:
        kept = {"total", "books"}
        columns = {name: _grown(getattr(queue.log, name)) for name in queue.log._fields if name not in kept}
        return queue._replace(log=queue.log._replace(**columns))
    if code == events.CONTACTS_FULL:
        return queue._replace(cluster=_more_contacts(queue.cluster), patch_work=_more_patch_work(queue.patch_work))
    pairs = _more_pairs(queue.pairs)
    added = len(pairs.bodies) - len(queue.pairs.bodies)
    cluster = queue.cluster._replace(
        pairs=_grown(queue.cluster.pairs), pair_tick=_grown(queue.cluster.pair_tick, fill=0)
    )
    return queue._replace(pairs=pairs, heap=_more_items(queue.heap, added), cluster=cluster)


def _grown(column: Any, added: int | None = None, fill: float = 0) -> Any:
    """A copy of an array with rows added, as many as there are unless told."""
    more = np.full((len(column) if added is None else added, *column.shape[1:]), fill, dtype=column.dtype)
    return np.concatenate([column, more])


def _more_contacts(cluster: Gathered) -> Gathered:
    contacts = type(cluster.contacts)(*(_grown(column) for column in cluster.contacts))
    report = cluster.report
    grown = report._replace(approach=_grown(report.approach), certificate=_grown(report.certificate))
    columns = {name: _grown(getattr(cluster, name)) for name in ("pair", "restitution", "friction", "impulse")}
    return cluster._replace(contacts=contacts, report=grown, **columns)


def _more_patch_work(work: PatchWork | None) -> PatchWork | None:
    if work is None:
        return None
    directions = Directions(*(_grown(column) for column in work.directions))
    points = PatchPoints(*(_grown(column) for column in work.points))
    return work._replace(pairs=_grown(work.pairs), directions=directions, points=points)


def _more_pairs(pairs: Pairs) -> Pairs:
    count, before = len(pairs.bodies), int(pairs.free_count[0])
    larger: Pairs = new_pairs(len(pairs.first), 2 * count)
    for name, old, new in zip(pairs._fields, pairs, larger, strict=True):
        if name not in {"free", "free_count"}:
            new[: len(old)] = old
    larger.free[:count] = np.arange(count, 2 * count)[::-1]
    larger.free[count : count + before] = pairs.free[:before]
    larger.free_count[0] = count + before
    return larger


def _more_items(heap: Heap, added: int) -> Heap:
    columns = {name: _grown(getattr(heap, name), added) for name in ("time", "rank", "item")}
    return heap._replace(place=_grown(heap.place, added, fill=-1), **columns)
