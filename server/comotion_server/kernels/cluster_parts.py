"""The parts of a cluster that chosen rows join through reacting bodies: each can be answered on its own, exactly."""

from typing import NamedTuple

import numpy as np

from comotion_server.kernels.jit import jit

NO_PART = -1


class Parts(NamedTuple):
    """Parts in the order of their first rows."""

    total: int
    of_row: np.ndarray  # (c,) int64 part of a row; NO_PART: not chosen
    of_member: np.ndarray  # (k,) int64 part of a member; NO_PART: no chosen row touches it
    rows: np.ndarray  # int64 the chosen rows, part after part, in their order
    members: np.ndarray  # int64 the members, part after part, ascending
    first_row: np.ndarray  # (count + 1,) int64 where a part begins in `rows`
    first_member: np.ndarray  # (count + 1,) int64 where a part begins in `members`


@jit
def find_root(parent, j):
    """The root of j, with the path to it halved."""
    while parent[j] != j:
        parent[j] = parent[parent[j]]
        j = parent[j]
    return j


@jit
def listed_by_part(of, count):
    """Indices sorted by their part, NO_PART left out, and where each part begins."""
    first = np.zeros(count + 1, np.int64)
    for part in of:
        if part != NO_PART:
            first[part + 1] += 1
    for part in range(count):
        first[part + 1] += first[part]
    listed, place = np.empty(first[count], np.int64), first[:count].copy()
    for i in range(len(of)):
        if of[i] != NO_PART:
            listed[place[of[i]]] = i
            place[of[i]] += 1
    return listed, first


@jit
def parts_of(link, chosen, member_count):
    """Splits the rows marked in chosen (c,); a row that touches no reacting body is a part of its own."""
    parent = np.arange(member_count)
    for i in range(len(link)):
        if chosen[i] and link[i, 0] >= 0 and link[i, 1] >= 0:
            a, b = find_root(parent, link[i, 0]), find_root(parent, link[i, 1])
            parent[max(a, b)] = min(a, b)
    of_row, of_root, count = np.full(len(link), NO_PART), np.full(member_count, NO_PART), 0
    for i in range(len(link)):
        if not chosen[i]:
            continue
        j = max(link[i, 0], link[i, 1])
        root = find_root(parent, j) if j >= 0 else -1
        if root >= 0 and of_root[root] != NO_PART:
            of_row[i] = of_root[root]
        else:
            of_row[i] = count
            if root >= 0:
                of_root[root] = count
            count += 1
    of_member = np.empty(member_count, np.int64)
    for j in range(member_count):
        of_member[j] = of_root[find_root(parent, j)]
    rows, first_row = listed_by_part(of_row, count)
    members, first_member = listed_by_part(of_member, count)
    return Parts(count, of_row, of_member, rows, members, first_row, first_member)
