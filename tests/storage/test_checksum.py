"""No line that was changed by a bit is read as if it had not been."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lockprobe.errors import BadValue
from lockprobe.storage.checksum import has_checksum, with_checksum, without_checksum

OBJECTS = st.dictionaries(st.text(max_size=5), st.one_of(st.integers(), st.text(max_size=9)), min_size=1, max_size=4)


@given(OBJECTS)
def test_a_line_comes_back_without_its_checksum(content):
    line = json.dumps(content).encode()
    marked = with_checksum(line)
    assert json.loads(marked) == {**content, "crc": json.loads(marked)["crc"]}
    assert has_checksum(marked)
    assert without_checksum(marked + b"\n") == line


@given(st.integers(0, 10**6))
def test_every_single_bit_is_noticed(number):
    """Within what the checksum covers it is refused; where the checksum itself is no longer one, the field stays."""
    line = with_checksum(b'{"key":"a/p=0.2","steps":[1,2,3]}')
    place, bit = divmod(number % (8 * len(line)), 8)
    changed = bytearray(line)
    changed[place] ^= 1 << bit
    try:
        read = without_checksum(bytes(changed))
    except BadValue:
        return
    assert b"crc" in read or read != line[: line.index(b',"crc"')] + b"}"


@pytest.mark.parametrize("line", [b"{}", b'{"a":1}', b'{"crc":"12345678","a":1}', b"", b'{"a":"x,crc"}'])
def test_a_line_of_an_earlier_release_is_given_back(line):
    assert without_checksum(line) == line
    assert not has_checksum(line)
