"""What an ELF object file holds: its code, its constants, its functions (System V ABI, ch. 4)."""

from __future__ import annotations

import struct
from hashlib import sha256
from typing import Any

SYMBOLS, RELOCATIONS, ALLOCATED, FUNCTION, UNDEFINED = 2, 4, 2, 2, 0
UNWINDING = b".eh_frame"


def examined(code: bytes) -> tuple[int, str, dict[str, tuple[int, str]]]:
    """Of an ELF file: bytes of code and constants, their digest with relocations, and functions by name.

    Relocations count by where they lead; the name matters only of what is not in the file.
    """
    (start,) = struct.unpack_from("<Q", code, 40)
    width, count, names = struct.unpack_from("<HHH", code, 58)
    rows = [struct.unpack_from("<IIQQQQIIQQ", code, start + i * width) for i in range(count)]

    def name_at(place: int) -> bytes:
        return code[place : code.index(b"\0", place)]

    def content(row: Any) -> bytes:
        return code[row[4] : row[4] + row[5]]

    labels = [name_at(rows[names][4] + row[0]) for row in rows]
    kept = [i for i, row in enumerate(rows) if row[2] & ALLOCATED and not labels[i].startswith(UNWINDING)]
    table = next(row for row in rows if row[1] == SYMBOLS)
    symbols = list(struct.iter_unpack("<IBBHQQ", content(table)))
    texts = rows[table[6]][4]
    size, whole, functions = 0, sha256(), {}
    for i in kept:
        size += rows[i][5]
        whole.update(labels[i] + content(rows[i]))
    for row in rows:
        if row[1] == RELOCATIONS and row[7] in kept:
            for offset, kind, addend in struct.iter_unpack("<QQq", content(row)):
                symbol = symbols[kind >> 32]
                target = name_at(texts + symbol[0]) if symbol[3] == UNDEFINED else labels[symbol[3]]
                whole.update(f"{offset} {kind & 0xFFFFFFFF} {addend} {target!r} {symbol[4]}".encode())
    for name, info, _, section, value, length in symbols:
        if info & 15 == FUNCTION and section in kept:
            body = content(rows[section])[value : value + length]
            functions[name_at(texts + name).decode()] = (length, sha256(body).hexdigest())
    return size, whole.hexdigest(), functions
