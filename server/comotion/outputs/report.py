"""The report of a run: one HTML page that needs nothing else, pictures included."""

from base64 import b64encode
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from html import escape
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from comotion_protocol.messages import Impact, OpenReply

LARGEST = 12  # impacts listed
SMALL = (640, 360)  # [pixels] of a frame in a row
TYPES = {".png": "image/png", ".gif": "image/gif"}
STYLE = """
:root{color-scheme:light dark;--ink:#22303c;--dim:#5d6d7a;--line:#d5dee6;--page:#f7f9fb;--card:#fff;--red:#b5482a}
@media(prefers-color-scheme:dark){:root{
--ink:#e4ebf1;--dim:#9fb0bd;--line:#33424f;--page:#141b21;--card:#1c252d;--red:#f0855f}}
*{box-sizing:border-box}body{margin:0;background:var(--page);color:var(--ink);font:16px/1.5 system-ui,sans-serif}
main{max-width:1060px;margin:0 auto;padding:2rem 1.2rem}h1{margin:0;font-size:1.8rem}
h2{margin:2.2rem 0 .6rem;font-size:1.15rem}
.sub{color:var(--dim);margin:.1rem 0 1.2rem}figure{margin:0 0 1rem}
figcaption{color:var(--dim);font-size:.88rem;margin-top:.25rem}
img{display:block;width:100%;border-radius:8px;border:1px solid var(--line);background:#fff}
.row{display:grid;grid-template-columns:repeat(auto-fit,minmax(300px,1fr));gap:.8rem}.wide{overflow-x:auto}
pre{overflow-x:auto;background:var(--card);border:1px solid var(--line);border-radius:8px;padding:.8rem 1rem;
font-size:.86rem}
table{border-collapse:collapse;width:100%;background:var(--card);border:1px solid var(--line);font-size:.92rem}
td,th{padding:.32rem .7rem;text-align:left;vertical-align:top;border-bottom:1px solid var(--line)}
th{font-weight:600;white-space:nowrap}td{font-variant-numeric:tabular-nums}
.warn{border-left:4px solid var(--red);background:var(--card);padding:.5rem .9rem;margin:.4rem 0}
.out td{color:var(--dim)}
"""


@dataclass
class Report:
    """What the page tells; pictures are files that may be missing."""

    title: str
    opened: "OpenReply"
    lines: Sequence[str]  # of the summary
    warnings: Sequence[str]
    motion: dict[str, str]
    largest: Sequence["Impact"]
    version: str
    folder: Path
    strip: Sequence[Path] = ()
    files: list[str] = field(default_factory=list)

    def write(self, path: Path) -> None:
        """Write the page."""
        parts = [
            f"<h1>{escape(self.title)}</h1><p class=sub>{escape(self._subtitle())}</p>",
            *(f"<p class=warn>{escape(text)}</p>" for text in self.warnings),
            self._figure("animation.gif", "the run; rings mark impacts, larger for a larger impulse")
            or self._figure("final.png", "the end of the run"),
            f"<h2>Summary</h2><pre>{escape(chr(10).join(self.lines))}</pre>",
            self._strip(),
            self._figure("resistance.png", "contact resistance", "<h2>Resistance</h2>"),
            self._plots(),
            self._impacts(),
            "<h2>What ran, and what was left out</h2>" + self._plan(),
            f"<h2>Files beside this page</h2><p>{escape(', '.join(self.files))}</p>",
        ]
        head = f"<!doctype html><html lang=en><meta charset=utf-8><title>{escape(self.title)} - comotion</title>"
        view = '<meta name=viewport content="width=device-width,initial-scale=1">'
        page = f"{head}{view}<style>{STYLE}</style><main>{''.join(parts)}</main></html>\n"
        path.write_text(page, encoding="utf-8")

    def _subtitle(self) -> str:
        kinds = [f"{list(self.motion.values()).count(kind)} {kind}" for kind in sorted(set(self.motion.values()))]
        triangles = sum(region.triangle_count for region in self.opened.regions)
        return f"comotion {self.version}; bodies with a surface: {', '.join(kinds)}; {triangles} triangles"

    def _strip(self) -> str:
        if not self.strip:
            return ""
        return "<h2>Frames</h2><div class=row>" + "".join(map(_small_image, self.strip)) + "</div>"

    def _plots(self) -> str:
        books = self._figure("books.png", "how the books of the impacts close")
        steps = self._figure("step_time.png", "how long the steps took on the wall clock")
        return f"<h2>Books and time</h2><div class=row>{books}{steps}</div>" if books or steps else ""

    def _figure(self, name: str, caption: str, head: str = "") -> str:
        path = self.folder / name
        if not path.is_file():
            return ""
        return f"{head}<figure>{_image(path, caption)}<figcaption>{escape(caption)}</figcaption></figure>"

    def _impacts(self) -> str:
        if not self.largest:
            return ""
        head = ("time [s]", "bodies", "impulse [N s]", "approach [m/s]", "e", "law", "point [m]")
        rows = [
            (
                f"{hit.time:.6f}",
                f"{hit.body_a} and {hit.body_b}",
                f"{hit.impulse:.5g}",
                f"{hit.approach_speed:.4g}",
                f"{hit.restitution:g}",
                hit.law,
                ", ".join(f"{value:.4g}" for value in hit.point),
            )
            for hit in self.largest
        ]
        return f"<h2>The {len(rows)} largest impacts</h2>" + _table(rows, head)

    def _plan(self) -> str:
        rows = "".join(
            f"<tr{'' if line.kept else ' class=out'}><th>{escape(line.stage)}</th>"
            f"<td>{'runs' if line.kept else 'left out'}</td><td>{escape(line.reason)}</td></tr>"
            for line in self.opened.plan
        )
        return f"<div class=wide><table>{rows}</table></div>"


def _table(rows: Iterable[Sequence[str]], head: Sequence[str] = ()) -> str:
    top = f"<tr>{''.join(f'<th>{escape(cell)}</th>' for cell in head)}</tr>" if head else ""
    body = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f"<div class=wide><table>{top}{body}</table></div>"


def _small_image(path: Path) -> str:
    """A frame as it is shown in a row of frames."""
    from PIL import Image

    data = BytesIO()
    Image.open(path).resize(SMALL, Image.Resampling.LANCZOS).save(data, "JPEG", quality=88)
    return _embedded(data.getvalue(), "image/jpeg", path.stem)


def _image(path: Path, text: str) -> str:
    return _embedded(path.read_bytes(), TYPES[path.suffix], text)


def _embedded(data: bytes, kind: str, text: str) -> str:
    return f'<img alt="{escape(text)}" src="data:{kind};base64,{b64encode(data).decode("ascii")}">'
