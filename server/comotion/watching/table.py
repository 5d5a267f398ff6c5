"""A running server as a table in the terminal; lines of text where no terminal is."""

import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

from comotion_protocol.messages import EventsNews, StatusReply
from comotion_protocol.watch_client import WatchClient

INTERVAL = 0.25  # [s] between drawings in a terminal
LINE_INTERVAL = 1.0  # [s] between lines of text
PACE_TIME = 5.0  # [s] over which the pace is measured


@dataclass
class Seen:
    """What has been seen since the watching began."""

    status: StatusReply
    steps: int = 0
    impacts: int = 0
    last: EventsNews | None = None
    worst_error: float = 0.0
    blocked: int = 0


class Watch:
    """Gathers events and progress from the link's thread."""

    def __init__(self, status: StatusReply) -> None:
        self._lock = threading.Lock()
        self._seen = Seen(status)
        self._began = self._mark = (time.monotonic(), status.time)

    def take_events(self, news: EventsNews) -> None:
        """One step."""
        books = news.books
        with self._lock:
            self._seen.steps += 1
            self._seen.impacts += books.impacts
            self._seen.last = news
            self._seen.blocked += news.status == "blocked"
            self._seen.worst_error = max(self._seen.worst_error, books.momentum, books.angular_momentum, books.energy)

    def take_progress(self, news: StatusReply) -> None:
        """What the server does now."""
        with self._lock:
            self._seen.status = news

    def rows(self) -> list[tuple[str, str]]:
        """Names and values of the table."""
        with self._lock:
            seen, status, last = self._seen, self._seen.status, self._seen.last
            pace = self._pace(status.time)
        books = f"{seen.worst_error:.1e} (relative)" if seen.impacts else "-"
        rows = [
            ("run", f"{status.run}, comotion {status.server.version}"),
            ("client", status.client.name if status.client else "none"),
            ("phase", status.phase),
            ("step", f"{status.step}" + (f", attempt {status.attempt}" if status.attempt else "")),
            ("time", f"{status.time:.6g} s"),
            ("pace", f"{pace:.3g} simulated seconds per second"),
            ("computing", f"{status.busy:.2f} s since the start"),
            ("seen", f"{seen.steps} steps, {seen.impacts} impacts, {seen.blocked} blocked"),
            ("worst error", books),
        ]
        if last is not None:
            budget = f"{last.budget.used} of {last.budget.limit} responses"
            rows.append(("last step", f"{last.books.impacts} impacts, {len(last.contacts)} pairs, {budget}"))
        if last is not None and last.blocked:
            names = sorted({name for block in last.blocked for name in block.bodies})
            rows.append(
                ("kept in place", ", ".join(names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else ""))
            )
        return rows

    def _pace(self, now: float) -> float:
        """Simulated time per time, over the last seconds."""
        wall = time.monotonic()
        if wall - self._mark[0] > PACE_TIME:
            self._began, self._mark = self._mark, (wall, now)
        return (now - self._began[1]) / max(wall - self._began[0], 1e-9)


def show_table(client: WatchClient, is_over: Callable[[], bool]) -> None:
    """Show until it is over or the server is gone."""
    watch = Watch(client.status())
    with client.listening({"events": watch.take_events, "progress": watch.take_progress}):
        if sys.stdout.isatty():
            _draw(watch, lambda: is_over() or not client.server_is_there)
        else:
            _print(watch, lambda: is_over() or not client.server_is_there)


def _draw(watch: Watch, is_over: Callable[[], bool]) -> None:
    from rich.live import Live
    from rich.table import Table
    from rich.text import Text

    def table() -> Table:
        grid = Table.grid(padding=(0, 2))
        for name, value in watch.rows():
            grid.add_row(Text(name, style="dim"), Text(value))  # Text: names from a run are no markup
        return grid

    with Live(table(), auto_refresh=False) as live:
        while not is_over():
            time.sleep(INTERVAL)
            live.update(table(), refresh=True)


def _print(watch: Watch, is_over: Callable[[], bool]) -> None:
    printed = -LINE_INTERVAL
    while not is_over():
        if time.monotonic() - printed >= LINE_INTERVAL:
            printed = time.monotonic()
            print("; ".join(f"{name}: {value}" for name, value in watch.rows()), flush=True)
        time.sleep(INTERVAL)
