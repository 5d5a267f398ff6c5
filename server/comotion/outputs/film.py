"""The frames of a run: states kept while it goes on, drawn at its end as pictures of one view, and as an animation."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from heapq import nlargest
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from comotion.outputs.picture import Mark, Painter, Still, painter

if TYPE_CHECKING:
    from PIL import Image

    from comotion_protocol.messages import Impact

MARKS = 200  # of the largest impacts are marked in a frame
LINGER = 2.5  # frames for which an impact is seen
LONGEST_LINGER = 0.1  # of the run: in a few pictures of a long one all impacts would be seen
TIME_ROUNDING = 1e-9  # [s]: sample times are sums of steps
GIF_SIZE = (800, 450)  # [pixels]
GIF_COLOURS = ((192, "MEDIANCUT"), (64, "MAXCOVERAGE"))  # the most frequent, and the rare ones of the rings
GIF_DELAY = (0.04, 0.25)  # [s] least and most between frames: real time where it lies between
LOOKS = 12  # states by which the view is chosen
STRIP = 6  # frames in the strip of the report


class Film:
    """States `interval` [s] of simulated time apart, from the first one that is added."""

    def __init__(self, interval: float) -> None:
        self.interval = interval
        self.times: list[float] = []  # [s]
        self._states: list[NDArray[np.float32]] = []
        self._poses: list[tuple[NDArray[np.float64], NDArray[np.float64]]] = []  # and scales
        self._impacts: list[list[Impact]] = [[]]  # before each state since the one before; the last: after the last
        self._next = -np.inf

    def add(
        self, time: float, points: NDArray[np.float64], poses: NDArray[np.float64], scales: NDArray[np.float64]
    ) -> None:
        """Keep a state if it is due: time [s], points [m], shape (n, 3), poses (bodies, 7), scales (bodies,)."""
        if time < self._next - TIME_ROUNDING:
            return
        if not self.times:
            self._next = time
        self.times.append(time)
        self._states.append(points.astype(np.float32))
        self._poses.append((poses, scales))
        self._impacts[-1] = _largest(self._impacts[-1])
        self._impacts.append([])
        self._next += self.interval * max(1.0, np.floor((time - self._next) / self.interval + 1.0 + TIME_ROUNDING))

    def add_impacts(self, impacts: Sequence["Impact"]) -> None:
        """Take the impacts of a step."""
        self._impacts[-1] += impacts
        if len(self._impacts[-1]) > 4 * MARKS:
            self._impacts[-1] = _largest(self._impacts[-1])

    def draw(self, folder: Path, still: Still, title: str, show: Callable[[int, int], None]) -> list[Path]:
        """Draw every state into `folder`; `show(done, of)` tells how far it is. Returns the pictures."""
        folder.mkdir(exist_ok=True)
        for old in folder.glob("frame_*.png"):
            old.unlink()
        latest = still.surface.points.copy()
        pictures = []
        still.surface.points[:] = self._states[0]
        with painter(replace(still, seen=self._seen(still))) as hand:
            for index in range(len(self.times)):
                path = folder / f"frame_{index:04d}.png"
                self._paint(hand, still, path, index, title)
                pictures.append(path)
                show(index + 1, len(self.times))
        still.surface.points[:] = latest
        return pictures

    def _paint(self, hand: Painter, still: Still, path: Path, index: int, title: str) -> None:
        still.surface.points[:] = self._states[index]
        if still.frames is not None:
            still.frames.place(*self._poses[index])
        hand.paint(path, self._marks(index), f"{title}   t = {self.times[index]:.3f} s")

    def _seen(self, still: Still) -> NDArray[np.float64]:
        """Points [m], shape (n, 3), of what moves, in states over the whole run."""
        points = []
        for index in np.unique(np.linspace(0, len(self._states) - 1, LOOKS).astype(int)):
            still.surface.points[:] = self._states[index]
            points.append(still.moving_points())
        return np.concatenate(points)

    def _marks(self, index: int) -> list[Mark]:
        now, longest = self.times[index], LONGEST_LINGER * (self.times[-1] - self.times[0])
        linger = min(LINGER * self.interval, max(longest, self.interval / 2))
        largest = max((hit.impulse for hits in self._impacts for hit in hits), default=0.0)
        recent = [hit for hits in self._impacts[max(0, index - int(LINGER) - 1) : index + 1] for hit in hits]
        return [
            Mark(hit.point, float(np.sqrt(max(hit.impulse, 0.0) / largest)), max(0.0, (now - hit.time) / linger))
            for hit in nlargest(MARKS, recent, key=lambda hit: hit.impulse)
            if now - hit.time < linger and largest > 0.0
        ]


def _largest(impacts: list["Impact"]) -> list["Impact"]:
    return nlargest(MARKS, impacts, key=lambda hit: hit.impulse)


def write_gif(path: Path, pictures: Sequence[Path], interval: float) -> None:
    """All pictures as one animation; real time, as far as frames `interval` [s] apart allow."""
    from PIL import Image

    small = [Image.open(picture).convert("RGB").resize(GIF_SIZE, Image.Resampling.LANCZOS) for picture in pictures]
    palette = _common_palette(small)
    frames = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in small]
    delay = round(1000 * min(max(interval, GIF_DELAY[0]), GIF_DELAY[1]))
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=delay, loop=0, optimize=False)


def _common_palette(images: Sequence["Image.Image"]) -> "Image.Image":
    """One palette for all frames, or colours flicker: from the first, a middle and the last one."""
    from PIL import Image

    chosen = [images[0], images[len(images) // 2], images[-1]]
    sheet = Image.new("RGB", (GIF_SIZE[0], GIF_SIZE[1] * len(chosen)))
    for row, image in enumerate(chosen):
        sheet.paste(image, (0, row * GIF_SIZE[1]))
    colours: list[int] = []
    for count, method in GIF_COLOURS:
        colours += (sheet.quantize(count, method=Image.Quantize[method]).getpalette() or [])[: 3 * count]
    palette = Image.new("P", (1, 1))
    palette.putpalette(colours)
    return palette
