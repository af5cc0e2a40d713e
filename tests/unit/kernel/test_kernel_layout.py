"""The structs in Python have the layout of those in C."""

from __future__ import annotations

from ctypes import c_int, sizeof

from tool0.kernel import drives, library, memory


def test_sizes_agree() -> None:
    compiled = library.load()
    assert compiled is not None
    in_python = [
        sizeof(memory.RobotStruct),
        sizeof(memory.LawStruct),
        8 * memory.PIECE_SIZE,
        sizeof(memory.GripStruct),
        sizeof(memory.StartStruct),
        *(
            sizeof(kind)
            for kind in (
                drives.Drives,
                drives._Table,
                drives.Body,
                drives._Bounds,
                drives._Goal,
                drives._Servo,
            )
        ),
        0,
    ]
    in_c = (c_int * len(in_python)).in_dll(compiled, "tool0_struct_sizes")
    assert list(in_c) == in_python
