"""The page of `comotion watch`: what it is told, to whom it is given, and that a browser shows it."""

import contextlib
import http.client
import json
import shutil
import threading
import time

import numpy as np
import pytest
from processes import run_command
from protocol_peers import PATIENCE, RUN, Peers

from comotion.watching.page_message import page_message

websockets_client = pytest.importorskip("websockets.sync.client", reason="websockets is in the extra `view`")

DT = 0.5
BAD_NAME = "<img src=x onerror=document.title='bad'>"


def decode(message):
    length = int.from_bytes(message[:4], "little")
    header = json.loads(message[4 : 4 + length])
    assert (4 + length) % 8 == 0
    arrays = {}
    for entry in header.pop("arrays"):
        count = int(np.prod(entry["shape"]))
        array = np.frombuffer(message, entry["dtype"], count, 4 + length + entry["offset"])
        arrays[entry["name"]] = array.reshape(entry["shape"])
    return header, arrays


class Page:
    """A page server in a thread, with any source."""

    def __init__(self, source):
        from comotion.watching.page_server import PageServer

        self.server = PageServer(source)
        self.port = int(self.server.address.rstrip("/").rpartition(":")[2])
        self._end = threading.Event()
        self._thread = threading.Thread(target=self.server.run, args=(self._end.is_set,))

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._end.set()
        self._thread.join(PATIENCE)
        assert not self._thread.is_alive()

    def get(self, path, **headers):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE)
        connection.request("GET", path, headers=headers)
        answer = connection.getresponse()
        return answer.status, answer.headers, answer.read()

    def feed(self, **options):
        return websockets_client.connect(f"ws://127.0.0.1:{self.port}/feed", max_size=None, **options)


class Still:
    """A source that says one thing."""

    def __init__(self, *messages):
        self.first = list(messages)
        self.inside = 0

    def enter(self):
        self.inside += 1
        return self.first

    def leave(self):
        self.inside -= 1

    def messages(self, seen):
        return seen, []


def wait_until(true):
    deadline = time.monotonic() + PATIENCE
    while not true():
        assert time.monotonic() < deadline
        time.sleep(0.005)


def test_messages_keep_every_bit():
    arrays = {"a": np.arange(5, dtype="<f4"), "b": np.array([[np.pi, -0.0, 5e-324]])}
    header, read = decode(page_message({"kind": "x", "name": "ü"}, arrays))
    assert header == {"kind": "x", "name": "ü"}
    for name, array in arrays.items():
        assert read[name].tobytes() == array.tobytes()


def test_files_are_given_with_a_policy_that_lets_nothing_else_in():
    with Page(Still()) as page:
        for path, kind in (
            ("/", "text/html"),
            ("/page.js", "text/javascript"),
            ("/three.module.min.js", "text/javascript"),
        ):
            status, headers, body = page.get(path)
            assert (status, headers["Content-Type"].split(";")[0]) == (200, kind)
            assert headers["Content-Security-Policy"].startswith("default-src 'none'; script-src 'self'")
            assert body
        for path in ("/../page_server.py", "/index.html", "/etc/passwd"):
            assert page.get(path)[0] == 404


def test_the_page_asks_for_nothing_from_elsewhere():
    with Page(Still()) as page:
        for path in ("/", "/page.js"):
            assert b"http" not in page.get(path)[2].replace(b"http://${location", b"")


@pytest.mark.parametrize(
    "headers",
    [{"Host": "evil.example"}, {"Host": "evil.example:1"}, {"Origin": "http://evil.example"}, {"Origin": "null"}],
)
def test_a_foreign_page_gets_nothing(headers):
    with Page(Still()) as page:
        assert page.get("/", **headers)[0] == 403
        assert page.get("/feed", **headers)[0] == 403


def test_a_foreign_page_gets_no_feed():
    from websockets.exceptions import InvalidStatus

    with Page(Still()) as page, pytest.raises(InvalidStatus, match="403"), page.feed(origin="http://evil.example"):
        pass


def test_a_page_that_talks_too_much_is_closed():
    from websockets.exceptions import ConnectionClosed

    source = Still(page_message({"kind": "gone"}))
    with Page(source) as page, page.feed() as feed:
        assert decode(feed.recv(PATIENCE))[0] == {"kind": "gone"}
        feed.send(b"x" * 2000)
        with pytest.raises(ConnectionClosed):  # 1009: too big
            feed.recv(PATIENCE)
        wait_until(lambda: source.inside == 0)


@contextlib.contextmanager
def live_page():
    from comotion.watching.live_source import LiveSource
    from comotion_protocol.watch_client import WatchClient

    with Peers("zenoh") as peers:
        peers.service.meet(peers.server)
        with WatchClient(RUN, peers.endpoint) as client, Page(LiveSource(client)) as page:
            yield peers, page


def test_a_live_page_is_told_of_every_impact_and_only_while_it_is_open():
    with live_page() as (peers, page):
        motion = peers.open()
        assert not peers.server.listens("state")
        with page.feed() as feed:
            scene, shapes = decode(feed.recv(PATIENCE))
            assert (scene["kind"], scene["title"], scene["mode"]) == ("scene", RUN, "live")
            assert [(b["name"], b["motion"]) for b in scene["bodies"]][-1] == ("wall-body", "fixed")
            assert len(shapes["corners"]) == len(shapes["normals"]) == 3 * 4 * 3
            assert decode(feed.recv(PATIENCE))[0]["step"] == 0
            assert decode(feed.recv(PATIENCE))[0]["kind"] == "progress"
            wait_until(lambda: peers.server.listens("state") and peers.server.listens("events"))
            impacts, state = [], None
            for _ in range(3):
                motion.step(DT, wrenches=np.ones((3, 6)))
            while state is None or state[0]["step"] < 3 or len(impacts) < 3:
                told = decode(feed.recv(PATIENCE))
                if told[0]["kind"] == "state":
                    state = told
                    impacts += told[0]["impacts"]
            assert [hit[0] for hit in impacts] == [DT, 2 * DT, 3 * DT]
            np.testing.assert_array_equal(state[1]["poses"], peers.engine.sample(0.0).poses)
        wait_until(lambda: not any(peers.server.listens(news) for news in ("state", "events", "progress")))


def test_a_live_page_shows_what_was_scaled_before_and_after_it_opened():
    with live_page() as (peers, page):
        motion = peers.open()
        peers.engine.scales[1] = 0.5
        motion.step(DT)
        with page.feed() as feed:
            scene, shapes = decode(feed.recv(PATIENCE))
            corner, count = scene["bodies"][1]["corners"]
            pose = peers.engine.sample(0.0)
            whole = pose.vertices["ice"] - pose.poses[1, :3]
            assert np.ptp(shapes["corners"][corner : corner + count]) == pytest.approx(np.ptp(whole) / 0.5)
            np.testing.assert_array_equal(decode(feed.recv(PATIENCE))[1]["scales"][:, 0], [1.0, 0.5, 1.0])
            wait_until(lambda: peers.server.listens("state"))
            peers.engine.scales[1] = 0.25
            motion.step(DT)
            told = {}, {}
            while (told[0].get("kind"), told[0].get("step")) != ("state", 2):
                told = decode(feed.recv(PATIENCE))
            np.testing.assert_array_equal(told[1]["scales"][:, 0], [1.0, 0.25, 1.0])


def test_watch_says_what_is_missing(tmp_path):
    done = run_command("watch", "--replay", tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("comotion: --replay: there is no bodies.vtkhdf in")
    done = run_command("watch", "--run", "none", "--connect", "tcp/127.0.0.1:9", "--table")
    assert done.returncode == 1
    assert "no server at tcp/127.0.0.1:9" in done.stderr


def recorded(folder):
    """A run of one cube that falls 2 m in 1 s and is half as large in the end, with one impact."""
    from cubes_by_hand import scene_of

    from comotion.outputs.surface_series import SurfaceSeries

    surface = scene_of(**{BAD_NAME: [100.0, 0, 2.0]})
    with SurfaceSeries(folder / "bodies.vtkhdf", surface, {BAD_NAME: "prescribed"}, 0.0) as series:
        for time_now in (0.0, 0.5, 1.0):
            poses = np.array([[100.0, 0, 2.0 - 2 * time_now, 1, 0, 0, 0]])
            scale = np.array([0.5 if time_now == 1.0 else 1.0])
            series.append(time_now, surface.points - [0, 0, 2 * time_now], poses, np.zeros((1, 6)), scale)
    text = "time [s],body_a,body_b,x [m],y [m],z [m],impulse [N s]\n0.75,a,b,100.0,0.0,0.0,3.0\n"
    (folder / "impacts.csv").write_text(text)


def test_a_recorded_run_is_all_there(tmp_path):
    from comotion.watching.replay_source import ReplaySource

    recorded(tmp_path)
    (scene, shapes), (film, arrays) = map(decode, ReplaySource(tmp_path).enter())
    assert scene["bodies"] == [{"name": BAD_NAME, "motion": "prescribed", "corners": [0, 36], "edges": [0, 24]}]
    assert scene["water"] == 0.0
    assert np.abs(shapes["corners"]).max() == 0.5  # about the body's own centre
    np.testing.assert_array_equal(arrays["times"], [0.0, 0.5, 1.0])
    np.testing.assert_allclose(arrays["poses"][:, 0, :3] + film["origin"], [[100, 0, 2], [100, 0, 1], [100, 0, 0]])
    np.testing.assert_array_equal(arrays["scales"], [[1.0], [1.0], [0.5]])
    np.testing.assert_array_equal(arrays["impacts"], [[0.75, 100.0, 0.0, 0.0, 3.0]])


def test_a_browser_shows_it_and_takes_no_name_as_html(tmp_path):
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is in the extra `dev`")
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("there is no Chromium (apt install chromium)")
    from comotion.watching.replay_source import ReplaySource

    recorded(tmp_path)
    graphics = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
    with Page(ReplaySource(tmp_path)) as page, playwright.sync_playwright() as start:
        browser = start.chromium.launch(executable_path=chromium, args=graphics)
        tab = browser.new_page()
        asked, errors = [], []
        tab.on("request", lambda request: asked.append(request.url))
        tab.on("pageerror", lambda error: errors.append(str(error)))
        tab.goto(page.server.address)
        wait_until(lambda: tab.evaluate("window.comotion?.states === 3 && window.comotion.frames > 1"))
        tab.evaluate("document.getElementById('play').click()")  # pause
        tab.evaluate(
            "const t = document.getElementById('time'); t.value = 0.75; t.dispatchEvent(new Event('input')); undefined"
        )
        height = tab.evaluate("window.comotion.view.meshes[0].position.z + window.comotion.view.origin[2]")
        assert height == pytest.approx(0.5, abs=1e-6)  # halfway between two states
        scale = "const t = document.getElementById('time'); t.value = 1; t.dispatchEvent(new Event('input'));"
        assert tab.evaluate(scale + "window.comotion.view.meshes[0].scale.x") == 0.5
        tab.evaluate("window.comotion.view.picked = 0")
        wait_until(lambda: BAD_NAME in tab.inner_text("#body"))
        assert tab.title() == f"{tmp_path.name} - comotion"
        assert "impacts\n1" in tab.inner_text("#figures")
        browser.close()
    assert errors == []
    assert all(url.startswith(page.server.address) for url in asked)
