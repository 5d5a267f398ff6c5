"""A process that serves the trivial engine on an endpoint; `hold` keeps its steps from ending. Tests kill it.

python serve_trivial.py ENDPOINT [hold]
"""

import signal
import sys
import threading

from trivial_engine import TrivialEngine

from comotion_server.serving import serve


def main(endpoint, *options):
    engine = TrivialEngine()
    if "hold" in options:
        engine.hold.clear()
    stop = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: stop.set())
    serve(engine, "test", [endpoint], stop=stop, on_ready=lambda: print("ready", flush=True))  # noqa: T201


if __name__ == "__main__":
    main(*sys.argv[1:])
