"""Golden bytes: both ways, complete, and as the committed files say."""

import json

import pytest

from comotion_protocol import codec, vectors
from comotion_protocol.errors import CODES, LocalProtocolError, RemoteProtocolError

DECODE_REPLY = {
    "open": codec.decode_open_reply,
    "step": codec.decode_step_reply,
    "close": codec.decode_close_reply,
    "status": codec.decode_status_reply,
    "look": codec.decode_look_reply,
}


def golden(file):
    return json.loads((vectors.FOLDER / file).read_text())


def by_name(file):
    return {case["name"]: case for case in golden(file)}


def test_files_are_what_the_generator_writes():
    for name, cases in vectors.files().items():
        assert (vectors.FOLDER / name).read_text() == vectors.text(cases)


@pytest.mark.rule("M1", "B2", "B3", "B4", "B5", "B12")
@pytest.mark.parametrize("name", vectors.requests())
def test_request_both_ways(name):
    message, request = vectors.requests()[name]
    case = by_name("requests.json")[name]
    header, bulk = bytes.fromhex(case["header"]), bytes.fromhex(case["bulk"])
    decoded = codec.decode_request(case["message"], header, bulk)
    assert case["message"] == message
    assert type(decoded) is type(request)
    assert vectors.plain(decoded) == case["meaning"] == vectors.plain(request)
    for message_form in (request, decoded):
        frame = codec.encode_request(message_form)
        assert (frame.header, frame.bulk()) == (header, bulk)


@pytest.mark.rule("M1", "B12")
@pytest.mark.parametrize("name", vectors.replies())
def test_reply_both_ways(name):
    message, reply = vectors.replies()[name]
    case = by_name("replies.json")[name]
    header, bulk = bytes.fromhex(case["header"]), bytes.fromhex(case["bulk"])
    decoded = DECODE_REPLY[message](header, bulk)
    assert vectors.plain(decoded) == case["meaning"] == vectors.plain(reply)
    for message_form in (reply, decoded):
        frame = codec.encode_reply(message_form)
        assert (frame.header, frame.bulk()) == (header, bulk)


@pytest.mark.rule("W3", "W4", "W5", "B12")
@pytest.mark.parametrize("name", vectors.news())
def test_news_both_ways(name):
    kind, news = vectors.news()[name]
    case = by_name("news.json")[name]
    header, bulk = bytes.fromhex(case["header"]), bytes.fromhex(case["bulk"])
    decoded = codec.decode_news(kind, header, bulk)
    assert vectors.plain(decoded) == case["meaning"] == vectors.plain(news)
    for news_form in (news, decoded):
        frame = codec.encode_news(news_form)
        assert (frame.header, frame.bulk()) == (header, bulk)


@pytest.mark.rule("E1", "E2", "E3")
def test_errors_both_ways():
    cases = golden("errors.json")
    assert [case["code"] for case in cases] == list(CODES)
    for case in cases:
        payload = bytes.fromhex(case["payload"])
        error = codec.decode_error(payload)
        assert (error.code, error.rule, error.message) == (case["code"], case["rule"], case["message"])
        assert error.detail == case["detail"]
        assert codec.encode_error(error) == payload
        servers_fault = case["code"] in {"failed", "busy", "stopping"}
        assert type(error) is (RemoteProtocolError if servers_fault else LocalProtocolError)


@pytest.mark.rule("B1", "B2", "B3", "B4", "B5", "B6", "B7", "B8", "B9", "B10", "B11", "F1", "K2", "M2", "M6")
@pytest.mark.parametrize("case", golden("refused.json"), ids=lambda case: case["name"])
def test_refused(case):
    with pytest.raises(RemoteProtocolError) as refusal:
        codec.decode_request(case["message"], bytes.fromhex(case["header"]), bytes.fromhex(case["bulk"]))
    assert (refusal.value.code, refusal.value.rule) == (case["code"], case["rule"])


def test_bytes_worked_out_by_hand():
    """A close request by the msgpack specification: map of 2, string 5 "lease", string 1, string 4 "step", 3."""
    by_hand = b"\x82" + b"\xa5lease" + b"\xa1L" + b"\xa4step" + b"\x03"
    assert codec.encode_request(codec.decode_request("close", by_hand, b"")).header == by_hand
    assert codec.decode_request("close", by_hand, b"") == vectors.m.CloseRequest(lease="L", step=3)
