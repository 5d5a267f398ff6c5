"""Messages to bytes and back (SPEC, sections B and M).

Encoding writes what it is given. Decoding trusts nothing and raises only RemoteProtocolError; what takes knowledge of
the run to judge (regions, shapes, finite forces, the lease) is left to the server.
"""

from comotion_protocol.error_codec import decode_error, encode_error
from comotion_protocol.news_codec import decode_news, encode_news
from comotion_protocol.reply_codec import (
    decode_close_reply,
    decode_look_reply,
    decode_open_reply,
    decode_status_reply,
    decode_step_reply,
    encode_reply,
)
from comotion_protocol.request_codec import decode_request, encode_request

__all__ = [
    "decode_close_reply",
    "decode_error",
    "decode_look_reply",
    "decode_news",
    "decode_open_reply",
    "decode_request",
    "decode_status_reply",
    "decode_step_reply",
    "encode_error",
    "encode_news",
    "encode_reply",
    "encode_request",
]
