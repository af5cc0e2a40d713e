import struct

import pytest

from tool0.devices.rtde_packets import (
    FORMATS,
    MAX_NAMES,
    Level,
    PacketBuffer,
    PacketType,
    field_names,
    layout,
    packet,
    text_packet,
)
from tool0.errors import TransportError
from tool0.ur.rtde.inputs import IN_USE, INPUTS, InputClaims
from tool0.ur.rtde.outputs import NOT_FOUND, OUTPUTS, output_types


def test_packets_survive_any_cuts() -> None:
    sent = [
        packet(PacketType.PROTOCOL_VERSION, b"\0\2"),
        packet(PacketType.START),
        packet(PacketType.DATA, bytes(range(200))),
    ]
    stream = b"".join(sent)
    for size in (1, 2, 3, 5, 64, len(stream)):
        buffer = PacketBuffer()
        got = [
            packet(PacketType(kind), payload)
            for start in range(0, len(stream), size)
            for kind, payload in buffer.feed(stream[start : start + size])
        ]
        assert got == sent


@pytest.mark.parametrize("size", [0, 1, 2])
def test_impossible_sizes_are_refused(size: int) -> None:
    with pytest.raises(TransportError, match=f"packet of {size} bytes"):
        list(PacketBuffer().feed(struct.pack(">HB", size, PacketType.DATA)))


def test_a_comma_at_the_end_of_names_means_nothing() -> None:
    assert field_names(b"timestamp,actual_q,") == ("timestamp", "actual_q")
    assert field_names(b"timestamp, actual_q") == ("timestamp", "actual_q")
    assert field_names(b"") == ()


def test_names_must_be_short_and_ascii() -> None:
    with pytest.raises(TransportError, match="at most 32768"):
        field_names(b"a," * MAX_NAMES)
    with pytest.raises(TransportError, match="ASCII"):
        field_names(b"\xff\xfe")


def test_text_has_the_layout_of_each_version() -> None:
    assert text_packet("no", Level.WARNING, 1)[3:] == b"\x02no"
    assert text_packet("no", Level.WARNING, 2)[3:] == b"\x02no\x05tool0\x02"
    assert len(text_packet("x" * 1000, Level.ERROR, 2)) < 300


def test_every_field_has_a_type_that_can_be_packed() -> None:
    kinds = {field.type for field in OUTPUTS.values()} | set(INPUTS.values())
    assert kinds <= set(FORMATS)
    assert layout(["VECTOR6D", "UINT8"], recipe_id=True).size == 1 + 48 + 1


def test_registers_are_numbered_as_in_the_guide() -> None:
    for direction in ("input", "output"):
        assert f"{direction}_bit_register_63" not in OUTPUTS
        assert OUTPUTS[f"{direction}_bit_register_64"].type == "BOOL"
        assert OUTPUTS[f"{direction}_bit_registers32_to_63"].type == "UINT32"
        assert OUTPUTS[f"{direction}_int_register_47"].type == "INT32"
        assert f"{direction}_double_register_48" not in OUTPUTS


def test_an_unknown_field_is_not_found() -> None:
    assert output_types(["timestamp", "actual_mood"]) == ("DOUBLE", NOT_FOUND)


def test_an_input_belongs_to_one_connection_until_that_ends() -> None:
    claims, first, second = InputClaims(), object(), object()
    names = ("input_int_register_0", "speed_slider_mask")
    assert claims.claim(names, first) == ("INT32", "UINT32")
    assert claims.claim(names, first) == ("INT32", "UINT32"), "by the same"
    assert claims.claim(("input_int_register_0",), second) == (IN_USE,)
    assert claims.claim(("input_int_register_1",), second) == ("INT32",)
    claims.release(first)
    assert claims.claim(names, second) == ("INT32", "UINT32")


def test_a_setup_that_fails_claims_nothing() -> None:
    claims, first, second = InputClaims(), object(), object()
    names = ("input_int_register_5", "input_mood")
    assert claims.claim(names, first) == ("INT32", NOT_FOUND)
    assert claims.claim(names[:1], second) == ("INT32",)
