"""Mutations of files: bits, numbers, words, lengths, ends."""

import random
import re

NUMBERS = [
    *(b"nan", b"inf", b"-inf", b"1e999", b"1e308", b"1e39", b"1e16", b"1e-320", b"-0", b"0", b"-1"),
    *(b"4294967295", b"4294967296", b"2147483648", b"-2147483649", b"9223372036854775808"),
    *(b"9" * 21, b"0x10", b"1e", b".", b"+", b"1,5", b"1_000", b"3", b"65536"),
]
WORDS = [
    *(b"\0" * 4, b"\xff" * 4, b"\xff\xff\xff\x7f", b"\0\0\0\x80", b"\0\0\xc0\x7f", b"\0\0\x80\x7f"),
    *(b"\xff" * 8, b"\0" * 8, b"\1\0\0\0", b"\xff\xff", b"\0\1"),
]
SIGNS = b'\0\n"[]{}()<>/\\-.eE+#%$&;:,= \t\xff'


def mutated(content: bytes, dice: random.Random) -> bytes:
    """The content with one to eight changes."""
    out = bytearray(content)
    for _ in range(dice.choice([1, 1, 1, 2, 4, 8])):
        if out:
            _change(out, dice)
    return bytes(out)


def _change(out: bytearray, dice: random.Random) -> None:
    kind, at = dice.randrange(11), dice.randrange(len(out))
    if kind == 0:
        del out[at:]
    elif kind in (1, 2):
        out[at] ^= 1 << dice.randrange(8)
    elif kind == 3:
        out[at:at] = bytes(dice.randrange(256) for _ in range(dice.randrange(1, 9)))
    elif kind in (4, 5):
        _swap(out, rb"-?\d+\.?\d*(?:e[-+]?\d+)?", dice, dice.choice(NUMBERS))
    elif kind == 6:
        del out[at : at + dice.randrange(1, 30)]
    elif kind == 7:
        word = dice.choice(WORDS)
        out[at : at + len(word)] = word
    elif kind == 8:
        out[at:at] = out[max(0, at - dice.randrange(1, 200)) : at] * dice.choice([1, 1, 5, 100])
    elif kind == 9:
        _swap(out, rb"[A-Za-z_]{3,}", dice)
    else:
        out[at] = dice.choice(SIGNS)


def _swap(out: bytearray, pattern: bytes, dice: random.Random, by: bytes | None = None) -> None:
    """Put `by`, or another match, in the place of a match."""
    found = list(re.finditer(pattern, bytes(out)))
    if found:
        one = dice.choice(found)
        out[one.start() : one.end()] = dice.choice(found).group() if by is None else by
