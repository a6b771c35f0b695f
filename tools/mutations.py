"""Ways in which the bytes of a file go wrong, for the fuzzer of the readers.

A mutation takes the bytes and a random generator and returns other bytes. Text and binary
files get the same ones: a number in the middle of a binary file does no harm. An archive is
also damaged inside, with its checksums made right again, so that what lies behind them is
reached.
"""

from __future__ import annotations

import io
import re
import struct
import zipfile
from collections.abc import Callable

import numpy as np

__all__ = ["mutated"]

Rng = np.random.Generator

_MOST = 6
_LONGEST = 64 << 20

_WORDS = (
    b"nan", b"inf", b"-inf", b"1e999", b"-1", b"0", b"-0", b"1e-320", b"99999999999999999999",
    b"2147483648", b"0x10", b"1,5", b"1_0", b"", b" ", b"\t", b"\n", b"\r\n", b"\0", b'"', b"'",
    b"#", b",", b";", b"{", b"}", b"[", b"<", b">", b"&", b"/", b"\\", b"%", b"\xff", b"\xfe\xff",
    b"\xef\xbb\xbf", b"\xc3\x28", b"e", b".", b"=", b":", b"(", b"PK\x03\x04", b"\x93NUMPY",
)  # fmt: skip
_NUMBERS = tuple(
    struct.pack(layout, number)
    for layout, numbers in {
        "<H": (0, 1, 0x7FFF, 0xFFFF),
        "<I": (0, 1, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF),
        "<Q": (0, 1, 1 << 31, 1 << 32, (1 << 63) - 1, (1 << 64) - 1),
        "<f": (float("nan"), float("inf"), -1.0, 3e38),
        "<d": (float("nan"), float("-inf"), -1.0, 1e308, 0.0),
    }.items()
    for number in numbers
)
_TOKEN = re.compile(rb"[^\s,;<>{}=:\"']+")
_TOKENS_LOOKED_AT = 4096


def mutated(content: bytes, rng: Rng) -> bytes:
    """Return `content` after one to six mutations, never the same bytes for nothing."""
    if content.startswith(b"PK\x03\x04") and rng.random() < 0.5:
        inside = _inside_archive(content, rng)
        if inside is not None:
            return inside
    # half of the inputs have one wound only: many hide what lies behind the first
    for _ in range(1 if rng.random() < 0.5 else int(rng.integers(2, _MOST + 1))):
        content = _ONE[int(rng.integers(len(_ONE)))](content, rng)
        if not content or len(content) > _LONGEST:
            break
    return content


def _place(content: bytes, rng: Rng) -> int:
    # half of the damage near the beginning, where the headers are
    if rng.random() < 0.5:
        return int(rng.integers(min(len(content), 400)))
    return int(rng.integers(len(content)))


def _flip(content: bytes, rng: Rng) -> bytes:
    place = _place(content, rng)
    return content[:place] + bytes([content[place] ^ 1 << rng.integers(8)]) + content[place + 1 :]


def _byte(content: bytes, rng: Rng) -> bytes:
    place = _place(content, rng)
    return content[:place] + bytes([rng.integers(256)]) + content[place + 1 :]


def _word(content: bytes, rng: Rng) -> bytes:
    place, word = _place(content, rng), _WORDS[int(rng.integers(len(_WORDS)))]
    return content[:place] + word + content[place + int(rng.integers(3)) :]


def _number(content: bytes, rng: Rng) -> bytes:
    place, number = _place(content, rng), _NUMBERS[int(rng.integers(len(_NUMBERS)))]
    return content[:place] + number + content[place + len(number) :]


def _token(content: bytes, rng: Rng) -> bytes:
    """Another word in the place of a whole one: a number, a name, a keyword."""
    start = 0 if len(content) < 20_000 else int(rng.integers(len(content) - 10_000))
    piece = content[start : start + 20_000]
    tokens = [match.span() for match in _TOKEN.finditer(piece)][:_TOKENS_LOOKED_AT]
    if not tokens:
        return _word(content, rng)
    first, last = tokens[int(rng.integers(len(tokens)))]
    if rng.random() < 0.3:
        other = tokens[int(rng.integers(len(tokens)))]
        word = piece[other[0] : other[1]]
    else:
        word = _WORDS[int(rng.integers(len(_WORDS)))]
    return content[: start + first] + word + content[start + last :]


def _cut(content: bytes, rng: Rng) -> bytes:
    return content[: _place(content, rng)]


def _remove(content: bytes, rng: Rng) -> bytes:
    place = _place(content, rng)
    return content[:place] + content[place + _length(content, rng) :]


def _repeat(content: bytes, rng: Rng) -> bytes:
    place = _place(content, rng)
    piece = content[place : place + _length(content, rng)]
    return content[:place] + piece * int(rng.integers(1, 5)) + content[place:]


def _move(content: bytes, rng: Rng) -> bytes:
    place, other = _place(content, rng), _place(content, rng)
    piece = content[other : other + _length(content, rng)]
    return content[:place] + piece + content[place + len(piece) :]


def _lines(content: bytes, rng: Rng) -> bytes:
    """Lose a line, double it, or let two change places."""
    if len(content) > 1 << 20:
        return _remove(content, rng)
    lines = content.split(b"\n")
    a, b = (int(k) for k in rng.integers(len(lines), size=2))
    kind = int(rng.integers(3))
    if kind == 0:
        del lines[a]
    elif kind == 1:
        lines.insert(a, lines[b])
    else:
        lines[a], lines[b] = lines[b], lines[a]
    return b"\n".join(lines)


def _length(content: bytes, rng: Rng) -> int:
    return int(rng.integers(1, 2 + int(min(len(content), 600) * rng.random() ** 3)))


_ONE: tuple[Callable[[bytes, Rng], bytes], ...] = (
    _flip,
    _byte,
    _word,
    _number,
    _token,
    _token,
    _cut,
    _remove,
    _repeat,
    _move,
    _lines,
)


def _inside_archive(content: bytes, rng: Rng) -> bytes | None:
    """Return a zip archive with one member damaged, lost or renamed; None if it is none."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            members = {info.filename: archive.read(info) for info in archive.infolist()}
    except (zipfile.BadZipFile, NotImplementedError):
        return None
    name = str(rng.choice(list(members)))
    kind = rng.random()
    if kind < 0.8:
        members[name] = mutated(members[name], rng)
    elif kind < 0.9:
        del members[name]
    else:
        members[f"{name}x"] = members.pop(name)
    changed = io.BytesIO()
    method = zipfile.ZIP_DEFLATED if rng.random() < 0.3 else zipfile.ZIP_STORED
    with zipfile.ZipFile(changed, "w", method) as archive:
        for member, data in members.items():
            archive.writestr(member, data)
    return changed.getvalue()
