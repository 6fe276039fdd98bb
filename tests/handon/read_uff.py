# A reader of universal files, written from the published descriptions of datasets 151, 164 and 58 (UC-SDRL, 1999), by
# fixed columns. read_uff.py EXPORT BINARY STRETCHES: checks what the file says and compares the values with the motion
# that was recorded.
import math
import struct
import sys


def columns(line, *widths):
    fields, at = [], 0
    for width in widths:
        fields.append(line[at : at + width].strip())
        at += width
    return fields


def datasets(data):
    at = 0

    def line():
        nonlocal at
        end = data.index(b"\n", at)
        text = data[at:end].decode("ascii")
        at = end + 1
        return text

    while at < len(data):
        assert line() == "    -1"
        first = line()
        number = int(first[:6])
        lines = []
        if number != 58:
            while (text := line()) != "    -1":
                lines.append(text)
            yield number, lines, None
            continue
        binary = first[6] == "b"
        lines = [line() for _ in range(11)]
        kind, count, even = (int(x) for x in columns(lines[6], 10, 10, 10))
        assert (kind, even) == (4, 1), "real, double precision, even"
        if binary:
            order, ieee, ascii_lines, size = (int(x) for x in columns(first[7:], 6, 6, 12, 12))
            assert (order, ieee, ascii_lines, size) == (1, 2, 11, 8 * count), first
            values = struct.unpack("<%dd" % count, data[at : at + size])
            at += size
        else:
            values = []
            while len(values) < count:
                text = line()
                assert len(text) % 20 == 0 and len(text) <= 80, text
                values += [float(text[i : i + 20]) for i in range(0, len(text), 20)]
        assert len(values) == count
        assert line() == "    -1"
        yield number, lines, values


export, binary, stretches = sys.argv[1], sys.argv[2] == "1", int(sys.argv[3])
data = open(export, "rb").read()
assert (b"\n    58b" in data) == binary
found = list(datasets(data))
assert [number for number, _, _ in found[:2]] == [151, 164]
header, units = found[0][1], found[1][1]
assert header[0].startswith("dwell run 00112233445566778899aabbccddeeff") and header[1].startswith("head ab12")
assert columns(header[3], 10, 10) == ["23-NOV-26", "03:12:17"], header[3]
assert columns(header[6], 10, 10) == ["24-NOV-26", "08:00:00"], header[6]
assert columns(units[0], 10, 20, 10) == ["1", "SI: Meter (newton)", "1"], units[0]
assert [float(x.replace("D", "E")) for x in columns(units[1], 25, 25, 25)] == [1, 1, 1], units[1]

amplitude, omega = 0.5e-3, 2 * math.pi * 4
truth = {
    "y0": lambda t: amplitude * math.sin(omega * t),
    "reaction": lambda t: amplitude * (240000 * math.sin(omega * t) + omega * 310 * math.cos(omega * t)),
    "oil/temp ?": lambda t: 41 + 0.01 * t,
}
expected = {"y0": ("8", "0", "1", "displacement", "m"), "reaction": ("9", "1", "1", "force", "N"), "oil/temp ?": ("0", "0", "0", "oil/temp ?C", "?C")}
seen = []
for number, lines, values in found[2:]:
    assert number == 58 and all(len(line) == 80 for line in lines)
    function = columns(lines[5], 5, 10, 5, 10, 1, 10, 10, 4, 1, 10, 10, 4)
    kind, channel, stretch, load, _, name, node, direction, _, reference = function[:10]
    assert (kind, load, reference) == ("1", "0", "NONE"), function
    seen.append((name, int(stretch)))
    assert lines[2].startswith("23-NOV-26 03:12:17"), lines[2]
    start, step = (float(x) for x in columns(lines[6], 30, 13, 13)[1:])
    assert columns(lines[7], 10, 5, 5, 5, 1, 20, 1, 20)[0] == "17"
    quantity, length, force, _, _, label, _, unit = columns(lines[8], 10, 5, 5, 5, 1, 20, 1, 20)
    assert (quantity, force, direction, label, unit) == expected[name], (lines[8], function)
    assert node == {"y0": "0", "reaction": "1", "oil/temp ?": "0"}[name], node
    assert columns(lines[9], 10)[0] == columns(lines[10], 10)[0] == "0"
    off = [value - truth[name](start + i * step) for i, value in enumerate(values)]
    rms = math.sqrt(sum(x * x for x in off) / len(off))
    words = lines[4].split()
    stated = float(words[words.index("rms") + 1].rstrip(","))
    assert words[:4] == ["error,", "noise", "included:", "rms"], lines[4]
    assert 0 < rms < stated < 40 * rms + 1e-4, (name, rms, stated)
    assert max(map(abs, off)) < 10 * stated, (name, max(map(abs, off)), stated)
    assert "band-limited to" in lines[3], lines[3]
    assert len(values) > 10
    if name != "oil/temp ?":
        assert abs(step - 0.005) < 1e-12, step
assert seen == [("y0", i + 1) for i in range(stretches)] + [("reaction", 1), ("oil/temp ?", 1)], seen
