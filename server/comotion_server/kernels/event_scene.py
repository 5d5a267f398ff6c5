"""What the event queue works on: the bodies with their shapes and flights, the rules of impacts, and its own arrays."""

from typing import NamedTuple

import numpy as np

from comotion_server.kernels.contacts import Contacts, new_contacts
from comotion_server.kernels.event_heap import Heap, new_heap
from comotion_server.kernels.flight import Bodies, Flights
from comotion_server.kernels.impact_cluster import Report, new_report
from comotion_server.kernels.impact_log import ImpactLog, new_impact_log
from comotion_server.kernels.impact_query import COUNTS, FINDINGS
from comotion_server.kernels.jit import jit
from comotion_server.kernels.mesh_room import PatchWork, Work
from comotion_server.kernels.neighbour_cells import Cells, new_cells
from comotion_server.kernels.pair_memory import Pairs, new_pairs
from comotion_server.kernels.solids import Solids

DELTA = 10.0  # times the tolerance of the time of impact: two bodies touch when their gap is no larger

# of `tally`: body of the timer that is due; row of a pair; hits that may still be answered; 1: the last one has been
TIMER, ROW, LEFT, ANSWERED = 0, 1, 2, 3
# impacts whose reflections did not end, or that had no elastic answer: energy was lost
CUT_SHORT = 10
# hits so far; those in a row of one pair at one time, and the most of them; new rooms, items and times of impact asked
HITS, RUN, LONGEST_RUN, ROOMS, ITEMS, ASKED, TALLIES = 4, 5, 6, 7, 8, 9, 11

NOW, UNTIL = 0, 1  # of `now`


class Scene(NamedTuple):
    """The bodies, n rows in the order of their names, and their states, each at the time when it was last looked at."""

    bodies: Bodies
    solids: Solids
    flights: Flights
    x: np.ndarray  # (n,3) [m]
    v: np.ndarray  # (n,3) [m/s]
    R: np.ndarray  # (n,3,3) body to world
    L: np.ndarray  # (n,3) [kg m2/s]
    w: np.ndarray  # (n,3) [rad/s]


class Rules(NamedTuple):
    """How impacts are answered."""

    material: np.ndarray  # (n,) int64 of each body
    restitution: np.ndarray  # (k,k) between materials
    friction: np.ndarray  # (k,k)
    law: int  # TOGETHER or SEQUENTIAL
    angle: float  # [rad] up to which faces count as level; 0: only points within reach make contact
    duration: float  # [s] of an impact: what closes within it is one contact
    resting: bool  # contacts that come to rest are handed to the caller
    merging: bool  # so are impacts without restitution


class Gathered(NamedTuple):
    """A cluster: bodies in contact at one time, the hit pair first, and their contact points."""

    bodies: np.ndarray  # (n,) int64
    pairs: np.ndarray  # (p,) int64 rows of the pairs
    contacts: Contacts  # c rows
    pair: np.ndarray  # (c,) int64 row of the pair of each contact
    restitution: np.ndarray  # (c,)
    friction: np.ndarray  # (c,)
    impulse: np.ndarray  # (c,3) on b [N s]
    report: Report
    ledgers: np.ndarray  # (5,7) work space of the books
    size: np.ndarray  # (3,) int64 how many bodies, pairs, contacts
    body_tick: np.ndarray  # (n,) int64 the cluster that a body was gathered to last
    pair_tick: np.ndarray  # (p,) int64 the cluster for which a pair was looked at last
    tick: np.ndarray  # (1,) int64 number of this cluster


BODIES, PAIRS, CONTACTS = 0, 1, 2  # of `size`


class Queue(NamedTuple):
    """All that the event queue remembers and works with; copies of the arrays are a checkpoint.

    Items of the heap: i, when body i leaves its room; n + i, a timer that the caller may set for body i; 2 n + k, when
    pair k may touch.
    """

    heap: Heap
    cells: Cells
    pairs: Pairs
    cluster: Gathered
    log: ImpactLog
    tolerance: np.ndarray  # (n,) gap that counts as contact, by the body's size [m]; inf for planes
    grain: np.ndarray  # (n,) and at least this, by the coordinates [m]
    held: np.ndarray  # (n,) bool: hits of these bodies are handed to the caller
    now: np.ndarray  # (2,) NOW, local time [s], and UNTIL when the flights are played
    tally: np.ndarray  # (TALLIES,) int64
    counts: np.ndarray  # (COUNTS,) int64 cost of the times of impact
    findings: np.ndarray  # (FINDINGS,) of the last time of impact
    work: Work | None  # None: all contact times have closed forms
    patch_work: PatchWork | None
    found: np.ndarray  # (n,) int64 work space
    turned: np.ndarray  # (3,) work space


@jit
def new_queue(x, radius, tolerance, grain, pair_capacity, contact_capacity, log_capacity, work, patch_work):
    """A queue for n bodies at x (n,3) with spheres of `radius` (n,) [m]; it knows no pairs yet."""
    n = len(radius)
    cluster = Gathered(
        np.empty(n, np.int64),
        np.empty(pair_capacity, np.int64),
        new_contacts(contact_capacity),
        np.empty(contact_capacity, np.int64),
        np.empty(contact_capacity),
        np.empty(contact_capacity),
        np.zeros((contact_capacity, 3)),
        new_report(contact_capacity),
        np.zeros((5, 7)),
        np.zeros(3, np.int64),
        np.zeros(n, np.int64),
        np.zeros(pair_capacity, np.int64),
        np.zeros(1, np.int64),
    )
    return Queue(
        new_heap(2 * n + pair_capacity),
        new_cells(radius, x),
        new_pairs(n, pair_capacity),
        cluster,
        new_impact_log(log_capacity),
        tolerance,
        grain,
        np.zeros(n, np.bool_),
        np.zeros(2),
        np.zeros(TALLIES, np.int64),
        np.zeros(COUNTS, np.int64),
        np.zeros(FINDINGS),
        work,
        patch_work,
        np.empty(n, np.int64),
        np.empty(3),
    )
