"""News to bytes and back (SPEC, section W): what a server publishes for those who watch."""

from comotion_protocol import limits
from comotion_protocol import messages as m
from comotion_protocol.blocks import Frame
from comotion_protocol.errors import RemoteProtocolError
from comotion_protocol.header import pack
from comotion_protocol.message_parts import frame, given, read, rows_of, scale_block
from comotion_protocol.records import read_blocked, read_books, read_budget, read_contact, read_impact, record
from comotion_protocol.reply_codec import decode_status_reply, encode_reply


def encode_news(news: m.News) -> Frame:
    """The bytes of any news."""
    match news:
        case m.StateNews():
            values = {"step": news.step, "attempt": news.attempt, "time": news.time}
            return frame(values, {"poses": news.poses, "twists": news.twists} | scale_block(news.scales))
        case m.EventsNews():
            return _events_frame(news)
        case m.StatusReply():
            return encode_reply(news)


def decode_news(news: str, header: bytes, bulk: bytes) -> m.News:
    """The news that came on the key of `news`; raises RemoteProtocolError."""
    match news:
        case "state":
            return _decode_state(header, bulk)
        case "events":
            return _decode_events(header, bulk)
        case "progress":
            return decode_status_reply(header, bulk)
        case _:
            raise RemoteProtocolError("unknown_message", "K5", f"no news is called {news!r}")


def _decode_state(header: bytes, bulk: bytes) -> m.StateNews:
    fields, arrays = read(header, bulk, limits.REPLY_HEADER_BYTES)
    poses, twists, scales = rows_of(arrays, "poses", 7), rows_of(arrays, "twists", 6), rows_of(arrays, "scales", 1)
    if poses is None or twists is None or len(poses) != len(twists):
        raise RemoteProtocolError("missing", "W3", "a state has poses and twists of all bodies")
    if scales is not None and len(scales) != len(poses):
        raise RemoteProtocolError("wrong_shape", "W7", "a state has scales of all bodies or of none")
    return m.StateNews(
        step=fields.count("step"),
        attempt=fields.count("attempt"),
        time=fields.finite("time"),
        poses=poses,
        twists=twists,
        scales=scales,
    )


def _events_frame(news: m.EventsNews) -> Frame:
    values = given(
        step=news.step,
        attempt=news.attempt,
        time=news.time,
        dt=news.dt,
        status=news.status,
        budget=record(news.budget),
        books=record(news.books),
        blocked=None if news.blocked is None else [record(block) for block in news.blocked],
        impacts=[record(impact) for impact in news.impacts[: limits.IMPACTS]],
        contacts=[record(contact) for contact in news.contacts],
    )
    return Frame(pack(values))


def _decode_events(header: bytes, bulk: bytes) -> m.EventsNews:
    fields, _ = read(header, bulk, limits.REPLY_HEADER_BYTES)
    return m.EventsNews(
        step=fields.count("step"),
        attempt=fields.count("attempt"),
        time=fields.finite("time"),
        dt=fields.finite("dt"),
        status=fields.choice("status", ("ok", "blocked")),
        budget=read_budget(fields.map("budget")),
        books=read_books(fields.map("books")),
        blocked=tuple(map(read_blocked, fields.maps("blocked"))) if fields.has("blocked") else None,
        impacts=tuple(map(read_impact, fields.maps("impacts"))),
        contacts=tuple(map(read_contact, fields.maps("contacts"))),
    )
