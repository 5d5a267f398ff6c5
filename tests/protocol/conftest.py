"""Every test of a rule names it: `@pytest.mark.rule("S3")`. `peers` runs it over memory and over zenoh."""

import pytest
from protocol_peers import Peers


def pytest_configure(config):
    config.addinivalue_line("markers", "rule(*numbers): rules of protocol/SPEC.md that the test checks")


@pytest.fixture(params=["memory", "zenoh"])
def peers(request):
    with Peers(request.param) as peers:
        yield peers


@pytest.fixture
def link(peers):
    return peers.link()
