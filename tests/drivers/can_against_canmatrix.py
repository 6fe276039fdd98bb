"""Decodes random frames with canmatrix and with can_table, and counts the differences.

can_against_canmatrix.py CAN_TABLE DBC [FRAMES [SEED]]: exit 0 no difference, 1 some, 77 canmatrix is not installed.
"""
import io
import math
import random
import subprocess
import sys
from contextlib import redirect_stdout

try:
    with redirect_stdout(io.StringIO()):  # it prints what it does not support
        import canmatrix
        import canmatrix.formats
except ImportError:
    print("skipped: python3-canmatrix is not installed")
    sys.exit(77)

EPSILON = 2.0**-52


def random_id(frame, rng):
    """The frame's identifier; of a J1939 group with any priority, source and destination."""
    arbitration = frame.arbitration_id
    identifier = arbitration.id
    if frame.is_j1939:
        identifier = identifier & 0x03FFFF00 | rng.randrange(8) << 26 | rng.randrange(256)
        if identifier >> 16 & 0xFF < 240:
            identifier = identifier & ~0xFF00 | rng.randrange(256) << 8
    return identifier | (1 << 31 if arbitration.extended else 0)


def is_number(signal, frame, raw):
    """What has to be delivered as a number: J1939 keeps the uppermost two codes for error and not available."""
    if signal.is_float:
        return math.isfinite(raw)
    wide = frame.is_j1939 and not signal.is_signed and signal.size >= 8
    return not (wide and raw >> (signal.size - 8) >= 0xFE)


def differences(frame, expected, found):
    wrong = []
    if set(expected) != set(found):
        wrong.append(f"signals {sorted(expected)}, found {sorted(found)}")
    for name in set(expected) & set(found):
        raw, (found_raw, found_value) = expected[name].raw_value, found[name]
        signal = frame.signal_by_name(name)
        if not is_number(signal, frame, raw):
            if found_value != "invalid":
                wrong.append(f"{name}: {raw} is no number, found {found_value}")
            continue
        if (float(found_raw) if signal.is_float else int(found_raw)) != raw:
            wrong.append(f"{name}: raw {raw}, found {found_raw}")
        value = float(expected[name].phys_value)
        scale = abs(float(signal.factor) * raw) + abs(float(signal.offset))
        if found_value in ("invalid", "short") or abs(float(found_value) - value) > 4 * EPSILON * scale + 5e-324:
            wrong.append(f"{name}: {value!r}, found {found_value}")
    return wrong


def main():
    program, path = sys.argv[1:3]
    count = int(sys.argv[3]) if len(sys.argv) > 3 else 12000
    rng = random.Random(int(sys.argv[4]) if len(sys.argv) > 4 else 1)
    matrix = canmatrix.formats.loadp_flat(path)
    frames = [frame for frame in matrix.frames if frame.signals and frame.size > 0]
    sent = []
    for _ in range(count):
        frame = rng.choice(frames)
        fill = rng.choice([None, None, None, None, 0x00, 0xFF])
        data = bytes(rng.randrange(256) if fill is None else fill for _ in range(frame.size))
        sent.append((frame, random_id(frame, rng), data))
    lines = "".join(f"{identifier:x} {data.hex()}\n" for _, identifier, data in sent)
    output = subprocess.run([program, path], input=lines, capture_output=True, text=True, check=True).stdout
    answers = output.split("frame\n")[1:]
    assert len(answers) == count, f"{count} frames, {len(answers)} answers"
    signals = bad = 0
    for (frame, identifier, data), answer in zip(sent, answers):
        found = {}
        wrong = []
        for line in answer.splitlines():
            message, name, raw, value = line.split()
            if message != frame.name:
                wrong.append(f"taken for {message}")
            found[name] = (raw, value)
        wrong += differences(frame, frame.decode(data), found)
        signals += len(found)
        if wrong:
            bad += 1
            if bad <= 10:
                print(f"{frame.name} {identifier:x} {data.hex()}: " + "; ".join(wrong))
    print(f"{count} frames of {len(frames)} messages, {signals} signals, {bad} frames differ")
    return 1 if bad or signals < count else 0


if __name__ == "__main__":
    sys.exit(main())
