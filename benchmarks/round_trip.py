"""What a step costs beyond the physics: forces there, vertices back, beside a bare zenoh `get` and a bare TCP socket.

    python benchmarks/round_trip.py [--rounds N]

Every peer is two processes of its own on this machine, so that none lives on the memory settings of another, and
carries the same payload: n vertices as float64, both ways. They take turns by bursts of round trips, so that a noisy
machine troubles all alike; figures are medians. Ours is the whole of it: `MotionClient`, codec, session, checks of the
forces, the desk's worker, the kept reply; the engine behind it is fixed and costs next to nothing. The bare peers only
move bytes: `get` hands them over as bytes, the socket receives into fresh memory.

Targets: at most the bare get + 200 us up to 10 000 vertices, at most 1.5 times the bare get beyond (both plain);
with shared memory at 1 000 000 vertices at most the socket. Exit code 1 if one is missed.
"""

import argparse
import multiprocessing
import os
import platform
import socket
import statistics
import sys
import threading
import time
from types import SimpleNamespace

import numpy as np
import zenoh
import zenoh.shm

from comotion_protocol import MotionClient, Wants
from comotion_protocol.zenoh_settings import configure

SIZES = (100, 10_000, 100_000, 1_000_000)
ROUNDS = {100: 20, 10_000: 20, 100_000: 15, 1_000_000: 10}
BURST = {100: 25, 10_000: 25, 100_000: 8, 1_000_000: 4}  # round trips in a row
SMALL = 10_000
ALLOWANCE = 200e-6  # [s] over the bare get up to SMALL vertices
FACTOR = 1.5  # times the bare get beyond


class FixedEngine:
    """Answers every step with the same vertices: what is measured is everything but the physics."""

    def __init__(self, vertex_count):
        rng = np.random.default_rng(1)
        self.time = 0.0
        vertices = rng.random((vertex_count, 3))
        triangles = np.arange(vertex_count // 3 * 3, dtype="<u4").reshape(-1, 3)
        body = SimpleNamespace(name="body", first_vertex=0, vertex_count=vertex_count)
        region = SimpleNamespace(
            name="body", vertex_count=vertex_count, triangles=triangles, moves=True, bodies=(body,)
        )
        self.regions = (region,)
        self.bodies = SimpleNamespace(names=("body",))
        self.plan = SimpleNamespace(explain=list)
        self._sample = SimpleNamespace(time=0.0, vertices={"body": vertices}, velocities={}, poses=None, twists=None)
        self._out = SimpleNamespace(
            time=0.0,
            dt=1e-3,
            status="ok",
            sums=SimpleNamespace(force=np.zeros(3), moment=np.zeros(3)),
            budget=SimpleNamespace(limit=0, used=0, exhausted=False),
            books=SimpleNamespace(
                momentum=0.0, angular_momentum=0.0, energy=0.0, overlaps=0, overlap_max=0.0, impacts=0
            ),
        )

    def step(self, dt, forces=None, wrenches=None):
        return self._out

    def sample(self, offset, *, vertices=True, velocities=False):
        return self._sample

    def mark_sent(self, sample):
        pass

    def checkpoint(self):
        return None

    def restore(self, checkpoint):
        pass


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


# Servers -------------------------------------------------------------------------------------------------------------


def serve_ours(vertex_count, port, shared_memory, ready, stop):
    from comotion_server.serving import serve

    serve(
        FixedEngine(vertex_count),
        "bench",
        [f"tcp/127.0.0.1:{port}"],
        shared_memory=shared_memory,
        stop=stop,
        on_ready=ready.set,
    )


def bare_config(mode, port):
    """The very settings that ours has, plain."""
    config = zenoh.Config()
    endpoint = [f"tcp/127.0.0.1:{port}"]
    configure(
        config,
        zenoh.Config(),
        mode=mode,
        listen=endpoint if mode == "peer" else [],
        connect=endpoint if mode == "client" else [],
        timeout=5.0,
        shared_memory=False,
        allow_insecure=False,
    )
    return config


def serve_get(vertex_count, port, ready, stop):
    reply = bytes(24 * vertex_count)

    def answer(query):
        with query:
            query.payload.to_bytes()
            query.reply("bench", reply)

    with zenoh.open(bare_config("peer", port)) as session:
        session.declare_queryable("bench", zenoh.handlers.Callback(answer, indirect=False), complete=True)
        ready.set()
        stop.wait()


def receive(connection, size):
    data = bytearray(size)
    view, done = memoryview(data), 0
    while done < size:
        count = connection.recv_into(view[done:])
        if count == 0:
            raise EOFError
        done += count
    return data


def serve_socket(vertex_count, port, ready, stop):
    reply = bytes(24 * vertex_count)
    with socket.create_server(("127.0.0.1", port)) as server:
        ready.set()
        connection, _ = server.accept()
        with connection:
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            while True:
                try:
                    receive(connection, len(reply))
                except EOFError:
                    return
                connection.sendall(reply)


def server_process(job, arguments, pipe):
    """One server in a process of its own, until it is told to stop."""
    ready, stop = threading.Event(), threading.Event()
    threading.Thread(target=job, args=(*arguments, ready, stop), daemon=True).start()
    if not ready.wait(30.0):
        raise TimeoutError(f"{job.__name__} does not start")
    pipe.send("ready")
    pipe.recv()
    stop.set()


# Clients ------------------------------------------------------------------------------------------------------------


class Ours:
    def __init__(self, port, shared_memory, forces):
        self.forces = {"body": forces}
        self.motion = MotionClient.open("bench", f"tcp/127.0.0.1:{port}", wants=Wants(), shared_memory=shared_memory)

    def ask(self):
        return self.motion.step(1e-3, self.forces).vertices["body"]

    def close(self):
        self.motion.close()


class Get:
    def __init__(self, port, forces):
        self.forces = forces.tobytes()
        self.session = zenoh.open(bare_config("client", port))

    def ask(self):
        replies = self.session.get(
            "bench",
            payload=self.forces,
            consolidation=zenoh.ConsolidationMode.NONE,
            congestion_control=zenoh.CongestionControl.BLOCK,
        )
        return next(reply.ok.payload.to_bytes() for reply in replies)

    def close(self):
        self.session.close()


class Socket:
    def __init__(self, port, forces):
        self.forces = forces.tobytes()
        self.connection = socket.create_connection(("127.0.0.1", port))
        self.connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def ask(self):
        self.connection.sendall(self.forces)
        return receive(self.connection, len(self.forces))

    def close(self):
        self.connection.close()


def client_process(kind, arguments, vertex_count, pipe):
    """One client in a process of its own: a burst of round trips when told to, and how long each took."""
    peer = kind(*arguments, np.random.default_rng(2).random((vertex_count, 3)))
    while pipe.recv() == "ask":
        taken = []
        for _ in range(BURST[vertex_count] + 1):
            started = time.perf_counter()
            answer = peer.ask()
            taken.append(time.perf_counter() - started)
            del answer
        pipe.send(taken[1:])  # the first one wakes everybody up
    peer.close()


class Peer:
    """A server and a client, each in a process of its own."""

    def __init__(self, job, kind, vertex_count, *options):
        port = free_port()
        self._server = self._start(server_process, job, (vertex_count, port, *options))
        self._server[1].recv()
        self._client = self._start(client_process, kind, (port, *options), vertex_count)

    @staticmethod
    def _start(target, *arguments):
        here, there = multiprocessing.Pipe()
        process = multiprocessing.get_context("spawn").Process(target=target, args=(*arguments, there))
        process.start()
        return process, here

    def burst(self):
        self._client[1].send("ask")
        return self._client[1].recv()

    def close(self):
        for process, pipe in (self._client, self._server):
            pipe.send("stop")
            process.join()


def measure(vertex_count, rounds):
    """Median round trip [s] of each peer."""
    peers = {
        "socket": Peer(serve_socket, Socket, vertex_count),
        "get": Peer(serve_get, Get, vertex_count),
        "ours": Peer(serve_ours, Ours, vertex_count, False),
        "ours, shared": Peer(serve_ours, Ours, vertex_count, True),
    }
    times = {name: [] for name in peers}
    for turn in range(rounds + 1):
        for name, peer in peers.items():
            taken = peer.burst()
            if turn > 0:  # the first burst opens connections and faults memory in
                times[name] += taken
    for peer in peers.values():
        peer.close()
    return {name: statistics.median(values) for name, values in times.items()}


def verdict(vertex_count, median):
    """The targets of this size: text and whether they hold."""
    if vertex_count <= SMALL:
        over = median["ours"] - median["get"]
        yield f"get + {over * 1e6:.0f} us (at most + {ALLOWANCE * 1e6:.0f} us)", over <= ALLOWANCE
    else:
        ratio = median["ours"] / median["get"]
        yield f"{ratio:.2f} x get (at most {FACTOR})", ratio <= FACTOR
    if vertex_count == SIZES[-1]:
        ratio = median["ours, shared"] / median["socket"]
        yield f"shared {ratio:.2f} x socket (at most 1)", ratio <= 1.0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=float, default=1.0, help="factor on the number of rounds")
    arguments = parser.parse_args()
    print(f"{platform.machine()}, {os.cpu_count()} cores, zenoh over TCP on loopback; medians [ms]")
    print(f"{'vertices':>9} {'socket':>9} {'get':>9} {'ours':>9} {'ours, shm':>9}  targets")
    good = True
    for size in SIZES:
        median = measure(size, max(5, round(ROUNDS[size] * arguments.rounds)))
        checks = list(verdict(size, median))
        good &= all(holds for _, holds in checks)
        figures = " ".join(f"{1e3 * median[name]:9.3f}" for name in ("socket", "get", "ours", "ours, shared"))
        print(f"{size:9d} {figures}  " + "; ".join(f"{text}: {'holds' if ok else 'MISSED'}" for text, ok in checks))
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
