"""Whatever bytes come: a message, or a RemoteProtocolError; never anything else, never more memory than the limits."""

import tracemalloc
from functools import partial

import msgpack
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comotion_protocol import codec, keys, limits, vectors
from comotion_protocol.errors import RemoteProtocolError
from comotion_protocol.header import pack, unpack

STEP = {"lease": "L", "step": 1, "attempt": 0, "dt": 0.1}

GOLDEN = [
    (message, codec.encode_request(request).header, bytes(codec.encode_request(request).bulk()))
    for message, request in vectors.requests().values()
]
REPLIES = [
    (message, codec.encode_reply(reply).header, bytes(codec.encode_reply(reply).bulk()))
    for message, reply in vectors.replies().values()
] + [
    (kind, codec.encode_news(news).header, bytes(codec.encode_news(news).bulk()))
    for kind, news in vectors.news().values()
]
DECODERS = {
    "open": codec.decode_open_reply,
    "step": codec.decode_step_reply,
    "close": codec.decode_close_reply,
    "status": codec.decode_status_reply,
    "look": codec.decode_look_reply,
    **{news: partial(codec.decode_news, news) for news in keys.NEWS},
}

anything = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**63), 2**64 - 1)
    | st.floats()
    | st.text(max_size=8)
    | st.binary(max_size=4),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
    max_leaves=12,
)


def tolerant(decode, *arguments):
    try:
        decode(*arguments)
    except RemoteProtocolError as error:
        codec.encode_error(error)


@given(st.sampled_from(sorted(DECODERS)), st.binary(max_size=200), st.binary(max_size=64))
def test_random_bytes(message, header, bulk):
    tolerant(codec.decode_request, message, header, bulk)
    tolerant(DECODERS[message], header, bulk)


@settings(max_examples=300)
@given(st.data())
def test_mutated_golden_bytes(data):
    message, header, bulk = data.draw(st.sampled_from(GOLDEN + REPLIES))
    changed = bytearray(header)
    for place in data.draw(st.lists(st.integers(0, max(0, len(header) - 1)), max_size=4)):
        if changed:
            changed[place] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(0, len(bulk)))
    tolerant(codec.decode_request, message, bytes(changed), bulk[:cut])
    tolerant(DECODERS[message], bytes(changed), bulk[:cut])


@settings(max_examples=300)
@given(st.data())
def test_values_replaced(data):
    """A well-formed header with one value, at any depth, replaced by anything."""
    message, header, bulk = data.draw(st.sampled_from(GOLDEN + REPLIES))
    values = unpack(header, limits.REPLY_HEADER_BYTES)
    spot = values
    while isinstance(spot, dict | list) and len(spot):
        key = data.draw(st.sampled_from(list(spot) if isinstance(spot, dict) else range(len(spot))))
        if data.draw(st.booleans()) or not isinstance(spot[key], dict | list):
            spot[key] = data.draw(anything)
            break
        spot = spot[key]
    tolerant(codec.decode_request, message, msgpack.packb(values), bulk)
    tolerant(DECODERS[message], msgpack.packb(values), bulk)


@given(st.binary(max_size=200))
def test_random_error_payloads(payload):
    tolerant(codec.decode_error, payload)


@pytest.mark.rule("B10")
@pytest.mark.parametrize(
    ("header", "bulk"),
    [
        (b"\xdf\xff\xff\xff\xff", b""),  # a map of 4 billion
        (b"\x81\xa1a\xdd\xff\xff\xff\xff", b""),  # a list of 4 billion
        (b"\x81\xa1a\xdb\xff\xff\xff\xff", b""),  # a string of 4 GiB
        (b"\x81\xa1a\xc6\xff\xff\xff\xff", b""),  # binary of 4 GiB
        (b"\x81\xa1a" * 100_000, b""),  # nested too deep
        (pack(STEP | {"blocks": [{"name": "a/forces", "dtype": "<f8", "shape": [2**29, 2**29]}]}), b""),
        (pack(STEP | {"blocks": [{"name": "a/forces", "dtype": "<f8", "shape": [2**28, 3]}]}), bytes(24)),
        (pack(STEP | {"blocks": [{}] * (limits.BLOCKS + 1)}), b""),
    ],
    ids=["map", "list", "string", "binary", "depth", "block", "large block", "blocks"],
)
def test_promised_sizes_are_not_allocated(header, bulk):
    tracemalloc.start()
    try:
        with pytest.raises(RemoteProtocolError):
            codec.decode_request("step", header, bulk)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 2 * limits.REQUEST_HEADER_BYTES


@pytest.mark.rule("B10")
def test_headers_and_bulk_have_a_largest_size():
    long = pack(STEP | {"note": ["x" * 4000] * 300})
    assert len(long) > limits.REQUEST_HEADER_BYTES
    with pytest.raises(RemoteProtocolError, match="at most 1048576"):
        codec.decode_request("step", long, b"")

    class Huge(bytes):
        def __len__(self):
            return limits.BULK_BYTES + 1

    with pytest.raises(RemoteProtocolError, match="bulk"):
        codec.decode_request("step", pack(STEP), Huge())


@pytest.mark.rule("B8", "B12")
def test_unknown_keys_nil_and_order_do_not_matter():
    header = pack({"dt": 0.1, "dt_next": None, "new": {"a": [1]}, "attempt": 0, "step": 1, "lease": "L"})
    request = codec.decode_request("step", header, b"")
    assert (request.lease, request.step, request.dt, request.dt_next) == ("L", 1, 0.1, None)
    # float32 and long integers are other forms of the same types
    other_forms = (
        b"\x84\xa5lease\xa1L\xa4step\xcf" + (1).to_bytes(8, "big") + b"\xa7attempt\xd0\x00\xa2dt\xca\x3f\x00\x00\x00"
    )
    assert codec.decode_request("step", other_forms, b"").dt == 0.5


@pytest.mark.rule("B5")
def test_elements_are_in_c_order():
    blocks = [{"name": "a/forces", "dtype": "<f8", "shape": [2, 3]}]
    bulk = np.arange(6.0).astype("<f8").tobytes()
    forces = codec.decode_request("step", pack(STEP | {"blocks": blocks}), bulk).forces["a"]
    assert forces.tolist() == [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]


@pytest.mark.rule("B9")
@pytest.mark.parametrize("bad", [float("nan"), float("inf"), -float("inf")])
def test_replies_hold_finite_numbers(bad):
    with pytest.raises(RemoteProtocolError) as refusal:
        codec.decode_close_reply(pack({"steps": 1, "time": bad}), b"")
    assert (refusal.value.code, refusal.value.rule) == ("not_finite", "B9")
