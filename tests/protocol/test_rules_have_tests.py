"""The numbered rules of SPEC.md are those that tests name, and its table of codes is that of the code."""

import re
from pathlib import Path

from comotion_protocol.errors import CODES

SPEC = Path(__file__).parents[2] / "protocol" / "SPEC.md"


def rules_of_spec():
    return re.findall(r"^- \*\*([A-Z]\d+)\*\*", SPEC.read_text(), re.MULTILINE)


def test_numbers_are_unique_and_count_up():
    numbers = rules_of_spec()
    for letter in {number[0] for number in numbers}:
        counted = [int(number[1:]) for number in numbers if number[0] == letter]
        assert counted == list(range(1, len(counted) + 1))


def test_every_rule_has_a_test_and_every_test_a_rule():
    marks = [
        mark
        for file in Path(__file__).parent.glob("test_*.py")
        for mark in re.findall(r"pytest\.mark\.rule\(([^)]*)\)", file.read_text())
    ]
    tested = {number for mark in marks for number in re.findall(r'"([A-Z]\d+)"', mark)}
    assert tested == set(rules_of_spec())


def test_every_rule_named_in_an_error_exists():
    code = [*SPEC.parent.glob("comotion_protocol/*.py"), *SPEC.parents[1].glob("server/comotion_server/*.py")]
    named = {number for file in code for number in re.findall(r'"([BEFKLMSZ]\d+)"', file.read_text())}
    assert named <= set(rules_of_spec())


def test_codes_are_listed():
    listed = dict(re.findall(r"^\| `(\w+)` \| ([^|]+) \|", SPEC.read_text(), re.MULTILINE))
    assert listed == CODES
