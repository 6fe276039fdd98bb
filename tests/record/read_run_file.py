#!/usr/bin/python3
"""An independent reader of run files, written from docs/run-file.md alone: it shares no line with Dwell.

    read_run_file.py FILE.dwell [--key VKEY] [--records OUT.csv] [--heads]

Prints one JSON object: whether the file is intact, open or tampered with, what the run was, its results, events and
signatures. --records writes every record of the stream, one a line; value as the 16 hexadecimal digits of its
binary64, so that nothing is rounded. --heads adds the head of every entry. Exit code 1: tampered.

Needs python3-zstandard and python3-cryptography.
"""
import argparse
import base64
import hashlib
import json
import os
import shutil
import sqlite3
import struct
import sys
import tempfile

import zstandard
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

MAX_RECORDS = 1 << 20  # of a block
WORD = 1 << 64
TABLES = ["CREATE TABLE entry (seq INTEGER PRIMARY KEY, kind TEXT NOT NULL, t_ns INTEGER NOT NULL, body BLOB NOT NULL, "
          "head BLOB NOT NULL) STRICT", "CREATE TABLE note (seq INTEGER PRIMARY KEY, text TEXT NOT NULL) STRICT"]


class Tampered(Exception):
    """What was found, and where."""


def check(condition, what):
    if not condition:
        raise Tampered(what)


def next_head(before, seq, kind, t_ns, body):
    kind = kind.encode("ascii")
    return hashlib.sha256(b"dwell entry v1\n" + before + struct.pack("<QQ", seq, len(kind)) + kind
                          + struct.pack("<qQ", t_ns, len(body)) + body).digest()


class Key:
    """A public key from its vkey, NAME+HASH+BASE64."""

    def __init__(self, vkey):
        self.vkey = vkey
        self.name, key_hash, key = vkey.split("+", 2)
        key = base64.b64decode(key, validate=True)
        check(len(key) == 33 and key[0] == 1, "the vkey is no Ed25519 key")
        self.hash = hashlib.sha256(self.name.encode() + b"\n" + key).digest()[:4]
        check(self.hash.hex() == key_hash, "the vkey's hash is not that of its key")
        self.public = Ed25519PublicKey.from_public_bytes(key[1:])

    def open(self, note, where):
        """The note's signed lines."""
        text, _, signature = note.rpartition("\n\n")
        text += "\n"
        check(signature.startswith("\u2014 ") and signature.endswith("\n"), f"{where}: no signature line")
        name, _, blob = signature[2:-1].partition(" ")
        check(name == self.name, f"{where}: signed by {name}, not by {self.name}")
        try:
            blob = base64.b64decode(blob, validate=True)
            check(len(blob) == 68 and blob[:4] == self.hash, f"{where}: the signature is by another key")
            self.public.verify(blob[4:], text.encode())
        except (InvalidSignature, ValueError):
            raise Tampered(f"{where}: the signature does not hold") from None
        return text.split("\n")[:-1]


def unzigzag(z):
    return z // 2 if z % 2 == 0 else -((z + 1) // 2)


def signed(word):
    return word - WORD if word >= WORD // 2 else word


def float_of(form, word):
    if form == 0:
        return float(signed(word))
    if form == 1:
        return struct.unpack("<f", struct.pack("<I", word))[0]
    return struct.unpack("<d", struct.pack("<Q", word))[0]


def records(body):
    """The records of a block: (t_ns, stamped_ns, value, t_half_ns, channel, kind, flags)."""
    version, n = struct.unpack_from("<II", body)
    check(version == 1 and n <= MAX_RECORDS, f"block of version {version} with {n} records")
    frame = body[8:]
    check(zstandard.frame_content_size(frame) == 33 * n, "the block does not hold what its records need")
    planes = zstandard.ZstdDecompressor().decompress(frame, max_output_size=33 * n)

    def numbers(first, size):
        low = [planes[(first + i) * n:(first + i + 1) * n] for i in range(size)]
        return [int.from_bytes(bytes(b), "little") for b in zip(*low)]

    columns = (numbers(0, 1), numbers(1, 1), numbers(2, 1), numbers(3, 2), numbers(5, 4), numbers(9, 8),
               numbers(17, 8), numbers(25, 8))
    t, gaps, halves, delays, values = 0, {}, {}, {}, {}
    for kind, flags, form, channel, half, instant, delay, value in zip(*columns):
        key = (kind, channel)
        gaps[key] = (gaps.get(key, 0) + unzigzag(instant)) % WORD
        t = (t + gaps[key]) % WORD
        delays[kind] = (delays.get(kind, 0) + unzigzag(delay)) % WORD
        halves[key] = (halves.get(key, 0) + half) % (1 << 32)
        form_before, a, b = values.get(key, (form, 0, 0))
        if form != form_before:
            a = b = 0
        word = (2 * a - b + unzigzag(value)) % WORD
        values[key] = (form, word, a)
        yield (signed(t), signed((t + delays[kind]) % WORD), float_of(form, word), halves[key], channel, kind, flags)


def rows(path, folder):
    """The rows of both tables, from a copy: SQLite would write to the file and to the -wal of one that was cut off."""
    copy = os.path.join(folder, "run.dwell")
    shutil.copyfile(path, copy)
    if os.path.exists(path + "-wal"):
        shutil.copyfile(path + "-wal", copy + "-wal")
    database = sqlite3.connect(copy)
    try:
        check(database.execute("PRAGMA application_id").fetchone()[0] == 0x44574C4C, "no run file")
        check(database.execute("PRAGMA user_version").fetchone()[0] == 2, "a version that this page does not tell of")
        found = [sql for sql, in database.execute("SELECT sql FROM sqlite_schema ORDER BY name")]
        check(found == TABLES, "other tables than those of a run file")
        notes = dict(database.execute("SELECT seq, text FROM note"))
        yield notes
        yield from database.execute("SELECT seq, kind, t_ns, body, head FROM entry ORDER BY seq")
    except sqlite3.DatabaseError as error:
        raise Tampered(f"not readable as a database: {error}") from None
    finally:
        database.close()


class Reader:
    """Reads a file from its first entry to its last and checks each."""

    def __init__(self, pinned, out):
        self.pinned, self.out = pinned, out
        self.key = self.origin = self.end = None
        self.head, self.seq = bytes(32), 0
        self.note, self.note_hash = 0, bytes(32)  # the last note
        self.covered = 0  # the last entry that a signature covers
        self.heads, self.result = [], {"records": 0, "samples": 0, "results": [], "estimates": [],
                                    "verifications": [], "events": [], "signatures": []}

    def read(self, path, folder):
        table = rows(path, folder)
        notes = next(table)
        for seq, kind, t_ns, body, head in table:
            where = f"entry {seq}"
            check(seq == self.seq + 1, f"{where}: expected entry {self.seq + 1}")
            before, self.seq = self.head, seq
            self.head = next_head(before, seq, kind, t_ns, body)
            check(self.head == head, f"{where}: the head is not that of the entry")
            self.heads.append(head.hex())
            self.take(where, kind, body)
            if kind == "signature":
                self.signature(where, before, json.loads(body))
            if seq in notes:
                note = notes.pop(seq)
                check(self.key.open(note, f"note {seq}") == [self.origin, str(seq), base64.b64encode(head).decode(), str(t_ns),
                                                             str(self.note), base64.b64encode(self.note_hash).decode()],
                      f"note {seq}: signs something else")
                self.note = self.covered = seq
                self.note_hash = hashlib.sha256(b"dwell note v1\n" + note.encode()).digest()
        check(not notes, f"notes without an entry: {sorted(notes)}")
        check(self.seq > 0, "no entries")
        check(self.covered == self.seq, f"entries from {self.covered + 1} on are not signed")

    def take(self, where, kind, body):
        check((kind == "run") == (where == "entry 1"), f"{where}: `{kind}` in this place")
        check(self.end is None or kind == "signature", f"{where}: `{kind}` after the end")
        if kind == "stream":
            self.stream(where, body)
        elif kind == "run":
            self.begin(json.loads(body))
        elif kind == "end":
            self.end = json.loads(body)
        elif kind in ("result", "estimate", "verification", "event"):
            self.result[kind + "s"].append(json.loads(body))

    def signature(self, where, head, value):
        """Of a person, over the head of the entry before."""
        check(self.end is not None and self.covered == self.seq - 1, f"{where}: a signature under what is not signed")
        check(value["seq"] == self.seq - 1 and value["head"] == head.hex(), f"{where}: signs another head")
        check(("person" in value) != ("vkey" in value), f"{where}: both by the service and by a key of their own, or by none")
        value["by"] = "the service" if "person" in value else value["vkey"]
        if "person" not in value:  # else the row of `note` tells
            words = [value["name"], value["meaning"], value.get("reason", ""), value["utc"]]
            lines = Key(value["vkey"]).open(value["note"], where)
            check(lines == ["dwell/signature/" + self.result["run"]["id"], str(value["seq"]),
                            base64.b64encode(head).decode()] + words, f"{where}: its note signs something else")
            self.covered = self.seq
        self.result["signatures"].append(value)

    def begin(self, run):
        self.result["run"] = run
        self.key = Key(run["vkey"])
        self.origin = "dwell/run/" + run["id"]
        check(self.pinned is None or self.pinned == run["vkey"], "entry 1: signed by another key than the one asked for")

    def stream(self, where, body):
        try:
            for record in records(body):
                self.result["records"] += 1
                self.result["samples"] += record[5] == 0
                if self.out:
                    bits = struct.pack(">d", record[2]).hex()
                    print(*record[:2], bits, *record[3:], sep=",", file=self.out)
        except (zstandard.ZstdError, struct.error) as error:
            raise Tampered(f"{where}: {error}") from None


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("file")
    arguments.add_argument("--key", help="the vkey that must have signed")
    arguments.add_argument("--records", help="file for the records of the stream")
    arguments.add_argument("--heads", action="store_true")
    asked = arguments.parse_args()
    reader = Reader(asked.key, open(asked.records, "w", encoding="ascii") if asked.records else None)
    result = {"file": asked.file, "state": "tampered", "where": None}
    with tempfile.TemporaryDirectory() as folder:
        try:
            reader.read(asked.file, folder)
            result["state"] = "open" if reader.end is None else "intact"
        except Tampered as found:
            result["where"] = str(found)
        except (ValueError, KeyError, TypeError) as error:
            result["where"] = f"entry {reader.seq}: not as the page tells: {error!r}"
    if reader.out:
        reader.out.close()
    result.update(reader.result, end=reader.end, head=reader.head.hex())
    if asked.heads:
        result["heads"] = reader.heads
    print(json.dumps(result, ensure_ascii=False))
    return 1 if result["state"] == "tampered" else 0


if __name__ == "__main__":
    sys.exit(main())
