"""Damaged tables: pieces that do harm, and where they are put."""

from __future__ import annotations

from hypothesis import strategies as st

TABLES = (
    b"d,g,x,n\nyes,f,A,3\nno,f,A,1\nyes,m,A,1\nno,m,A,1\nyes,f,B,2\nno,m,B,5\n",
    b"d,g,x,n\nyes,f,A,0.75\nno,f,A,0.25\nyes,m,A,0.5\nno,m,A,1/2\n",
    b"d;g;x;n\nyes;f;A;0,75\nno;f;A;0,25\nyes;m;A;1\n",
    b'"d","g","x","n"\r\n"yes","f","A\r\nB","3"\r\n"no","m","A\r\nB","1"\r\n',
)
PIECES = (
    *(b",", b";", b"\t", b"|", b"\n", b"\r", b"\r\n", b'"', b'""', b" ", b"\x00", b"\xef\xbb\xbf", b"\xff", b"\xe2\x80\xae", b"\xc2\x85"),
    *(
        b"\x1b[31m",
        b"\xe2\x80\xa8",
        b"\xed\xa0\x80",
        b"yes",
        b"no",
        b"f",
        b"m",
        b"A",
        b"0",
        b"1",
        b"-1",
        b"1/0",
        b"1/3",
        b"1e-4000",
        b"1e3950",
    ),
    *(
        b"1e4000",
        b"1e5000",
        b"nan",
        b"inf",
        b"0.5",
        b"0,5",
        b"1,234",
        b"\xd9\xa3",
        b"(missing)",
        b"d",
        b"g",
        b"x",
        b"n",
        b"9" * 4000,
        b".",
        b"+",
    ),
)


@st.composite
def damaged(draw: st.DrawFn) -> bytes:
    """A good table, a few places of which were cut, copied, moved or replaced."""
    content = draw(st.sampled_from(TABLES))
    for _ in range(draw(st.integers(0, 4))):
        start = draw(st.integers(0, len(content)))
        end = min(len(content), start + draw(st.integers(0, 12)))
        kind = draw(st.sampled_from(("cut", "copy", "put", "put", "put", "bytes")))
        piece = {
            "cut": b"",
            "copy": content[start:end] * 2,
            "put": draw(st.sampled_from(PIECES)) if kind == "put" else b"",
            "bytes": draw(st.binary(max_size=4)) if kind == "bytes" else b"",
        }[kind]
        content = content[:start] + piece + content[end:]
    return content


@st.composite
def filled(draw: st.DrawFn) -> bytes:
    """A well-formed table of odd cells."""
    odd = draw(st.booleans())
    number = st.sampled_from((b"0", b"1", b"2", b"0.5", b"1/3", b"0.25", b"1e-3", b"1e-4000", b"1e3950", b"7") + (b"", b"x") * odd)
    label = st.sampled_from(
        (b"yes", b"no", b"f", b"m", b"A", b"B", b'"a,b"', b'"=1\n2"', b"\xe2\x80\xae", b"\xe8\xaa\x9e", b"-q") + (b"", b"(missing)") * odd
    )
    decision = st.sampled_from((b"yes", b"no", b"maybe")) if not odd else label
    separator = draw(st.sampled_from((b",", b",", b";", b"\t")))
    rows = draw(st.lists(st.tuples(decision, label, st.sampled_from((b"A", b"B")), number), min_size=1, max_size=12))
    usual, others = (b"d", b"g", b"x", b"n"), ((b"decision", b"sex", b" race", b"n"), (b'"u,v"', b'"g""h"', b"-x", b"n"))
    header = draw(st.sampled_from((usual, usual, usual, *others)))
    return b"".join(separator.join(row) + b"\n" for row in (header, *rows))
