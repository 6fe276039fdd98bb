# The CSV export against the samples that were recorded: read_csv.py EXPORT SAMPLES FROM_NS TO_NS
# Instants equal to 1 ns (their decimals are taken exactly), values to the last bit.
import csv
import struct
import sys
from decimal import Decimal

export, samples, from_ns, to_ns = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
names = ["y0", "reaction", "oil/temp °C"]
units = {"y0": (0.1, -3.0, "mm"), "reaction": (0.25, 0.0, "N"), "oil/temp °C": (1.0, 0.0, "°C")}
expected = []
for line in open(samples):
    channel, t_ns, bits, _, _ = map(int, line.split())
    if from_ns <= t_ns <= to_ns:
        expected.append((t_ns, names[channel], struct.pack("<q", bits)))

with open(export, encoding="utf-8", newline="") as file:
    comments = []
    position = file.tell()
    while (line := file.readline()).startswith("#"):
        comments.append(line)
        position = file.tell()
    file.seek(position)
    rows = list(csv.DictReader(file))
assert len(rows) == len(expected) > 0, (len(rows), len(expected))
for row, (t_ns, name, bits) in zip(rows, expected):
    assert Decimal(row["t"]) * 10**9 == t_ns, (row, t_ns)
    assert row["channel"] == name, (row, name)
    assert struct.pack("<d", float(row["value"])) == bits, (row, bits)
    if "in_unit" in row:
        scale, offset, unit = units[name]
        assert float(row["in_unit"]) == scale * float(row["value"]) + offset, row
        assert row["unit"] == unit, row
text = "".join(comments)
for word in ["run 7", "head ab12", "K-2231, due 2027-03-31", "displacement of the table", "in mm = 0.1 * value + -3"]:
    assert word in text, (word, text)
