"""A loader of object code that does without LLVM: its library takes longer to load than a short run.

LLVM's code for immediate execution refers to everything by its full address (the large code model). On x86-64
all relocations are therefore of type R_X86_64_64, a sum of addresses (System V Application Binary Interface,
AMD64 Architecture Processor Supplement, sec. 4.4; the format of the file: System V ABI, ch. 4).
"""

from __future__ import annotations

import ctypes
import mmap
import struct
import sys
from typing import NamedTuple

from lagrange_cli.records import dataclass

RELOCATABLE, X86_64 = 1, 62
PROGRAM, SYMBOLS, RELOCATIONS = 1, 2, 4
WRITABLE, ALLOCATED, EXECUTABLE = 1, 2, 4
UNDEFINED = 0
FULL_ADDRESS = 1
UNWINDING = b".eh_frame"
"""Tables that only exceptions need."""


class Unsupported(Exception):
    """This object code needs LLVM's loader."""


class ObjectSection(NamedTuple):
    """A row of the table of sections."""

    name: int
    type: int
    flags: int
    address: int
    offset: int
    size: int
    link: int
    info: int
    alignment: int
    entry: int


@dataclass(frozen=True)
class Image:
    """Object code in memory, read-only and executable; ``memory`` keeps it there. So many bytes are
    ``instructions``; others are tables."""

    memory: mmap.mmap
    addresses: dict[str, int]
    instructions: int

    def address(self, function: str) -> int:
        """Where a function is, 0 if there is none of that name."""
        return self.addresses.get(function, 0)


def load_image(code: bytes) -> Image:
    """Object code in memory; raises ``Unsupported`` for anything but plain ELF code for x86-64."""
    if not (sys.platform.startswith("linux") and struct.calcsize("P") == 8):
        raise Unsupported("another platform")
    try:
        return _load(code)
    except (struct.error, IndexError, ValueError, OSError, AttributeError) as error:
        raise Unsupported(str(error)) from error


def _load(code: bytes) -> Image:
    sections = _sections(code)
    places, size = _arrange(sections, _names(code, sections))
    memory = mmap.mmap(-1, max(size, 1), prot=mmap.PROT_READ | mmap.PROT_WRITE)
    base = ctypes.addressof(ctypes.c_char.from_buffer(memory))
    for index, place in places.items():
        one = sections[index]
        memory[place : place + one.size] = code[one.offset : one.offset + one.size]
    table = next(section for section in sections if section.type == SYMBOLS)
    functions, values = _symbols(code, sections, table, {i: base + place for i, place in places.items()})
    for section in sections:
        if section.type == RELOCATIONS and section.info in places:
            _relocate(memory, places[section.info], code, section, values)
    _protect(base, len(memory))
    instructions = sum(sections[index].size for index in places if sections[index].flags & EXECUTABLE)
    return Image(memory, functions, instructions)


def _sections(code: bytes) -> list[ObjectSection]:
    if code[:6] != b"\x7fELF\x02\x01":
        raise Unsupported("not a little-endian ELF file of 64 bits")
    kind, machine = struct.unpack_from("<HH", code, 16)
    (start,) = struct.unpack_from("<Q", code, 40)
    width, count = struct.unpack_from("<HH", code, 58)
    if (kind, machine) != (RELOCATABLE, X86_64):
        raise Unsupported("not object code for x86-64")
    return [ObjectSection(*struct.unpack_from("<IIQQQQIIQQ", code, start + i * width)) for i in range(count)]


def _names(code: bytes, sections: list[ObjectSection]) -> list[bytes]:
    (index,) = struct.unpack_from("<H", code, 62)
    return [_text(code, sections[index].offset + section.name) for section in sections]


def _text(code: bytes, start: int) -> bytes:
    return code[start : code.index(b"\0", start)]


def _arrange(sections: list[ObjectSection], names: list[bytes]) -> tuple[dict[int, int], int]:
    """The offset of each section that is needed, and the size of all."""
    places: dict[int, int] = {}
    size = 0
    for index, section in enumerate(sections):
        if section.flags & ALLOCATED and section.size and not names[index].startswith(UNWINDING):
            if section.type != PROGRAM or section.flags & WRITABLE or section.alignment > mmap.PAGESIZE:
                raise Unsupported(f"section {names[index]!r}")
            size = -(-size // max(section.alignment, 1)) * max(section.alignment, 1)
            places[index] = size
            size += section.size
    return places, size


def _symbols(
    code: bytes, sections: list[ObjectSection], table: ObjectSection, bases: dict[int, int]
) -> tuple[dict[str, int], list[int | bytes]]:
    """Functions by name, and every symbol's address in order: its name where it is not in the file."""
    functions: dict[str, int] = {}
    values: list[int | bytes] = []
    texts = sections[table.link].offset
    for name, _, _, index, value, _ in struct.iter_unpack(
        "<IBBHQQ", code[table.offset : table.offset + table.size]
    ):
        text = _text(code, texts + name)
        if index == UNDEFINED or index not in bases:
            values.append(text)
            continue
        values.append(bases[index] + value)
        if text:
            functions[text.decode("ascii")] = bases[index] + value
    return functions, values


def _relocate(
    memory: mmap.mmap, place: int, code: bytes, section: ObjectSection, values: list[int | bytes]
) -> None:
    for offset, info, addend in struct.iter_unpack(
        "<QQq", code[section.offset : section.offset + section.size]
    ):
        if info & 0xFFFFFFFF != FULL_ADDRESS:
            raise Unsupported(f"relocation {info & 0xFFFFFFFF}")
        value = values[info >> 32]
        if isinstance(value, bytes):
            value = values[info >> 32] = _library(value)
        struct.pack_into("<Q", memory, place + offset, value + addend)


def _library(name: bytes) -> int:
    """The address of a function of the C library, as LLVM finds it; AttributeError if there is none."""
    function = getattr(ctypes.CDLL(None), name.decode("ascii"))
    return ctypes.cast(function, ctypes.c_void_p).value or 0


def _protect(start: int, size: int) -> None:
    """Make the memory executable and read-only."""
    protect = ctypes.CDLL(None, use_errno=True).mprotect
    protect.argtypes = (ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int)
    if protect(start, size, mmap.PROT_READ | mmap.PROT_EXEC):
        raise OSError(ctypes.get_errno(), "mprotect")
