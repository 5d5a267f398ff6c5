"""What is drawn flat over a picture: rings where bodies hit each other, and the caption."""

from collections.abc import Sequence

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from comotion.outputs.camera import Camera
from comotion.outputs.picture import MARK, SIZE, Mark

SMOOTH = 2  # drawn this much larger and scaled down, for smooth rings
RING = (5.0, 18.0)  # radius [pixels] of the smallest and the largest impact
GROWTH = 0.9  # by which share of its radius a ring grows until it is gone
FONT_SIZE = 22  # [pixels]


def draw_over(image: Image.Image, camera: Camera, marks: Sequence[Mark], caption: str) -> Image.Image:
    """The picture with marks and caption."""
    sheet = Image.new("RGBA", (SIZE[0] * SMOOTH, SIZE[1] * SMOOTH), (0, 0, 0, 0))
    pen = ImageDraw.Draw(sheet)
    for mark in sorted(marks, key=lambda mark: -mark.age):
        _ring(pen, camera, mark)
    if caption:
        font = ImageFont.load_default(FONT_SIZE * SMOOTH)
        pen.text((24 * SMOOTH, 18 * SMOOTH), caption, fill="#26323c", font=font)
    flat = sheet.reduce(SMOOTH)
    return Image.alpha_composite(image.convert("RGBA"), flat).convert("RGB")


def _ring(pen: ImageDraw.ImageDraw, camera: Camera, mark: Mark) -> None:
    place = camera.pixel(np.array(mark.point))
    if place is None:
        return
    x, y = (SMOOTH * value for value in place)
    radius = SMOOTH * (RING[0] + (RING[1] - RING[0]) * mark.size) * (1.0 + GROWTH * mark.age)
    fade = 1.0 - mark.age
    alpha = f"{round(255 * fade):02x}"
    box = (x - radius, y - radius, x + radius, y + radius)
    pen.ellipse(box, fill=f"{MARK}{round(45 * fade):02x}", outline=f"{MARK}{alpha}", width=2 * SMOOTH)
    dot = 2.0 * SMOOTH
    pen.ellipse((x - dot, y - dot, x + dot, y + dot), fill=f"{MARK}{alpha}")
