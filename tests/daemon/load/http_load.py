#!/usr/bin/env python3
"""What clients and attackers cost the measurement: the estimation thread's CPU time with and without them, samples dropped.

http_load.py BUILD [PAIRS [SECONDS]]

BUILD is a build folder with dwelld, rigsim and dwell-driver-modbus. 50 clients poll 20 times a second, 20 read the live
stream, half of them with traces; one of the 20 never reads. Stretches with and without clients alternate, so that a
machine that grows slower or warmer does so for both; the median of the pairs' ratios counts. One stretch more has attackers: 5000 connections, of which 300 send a byte a second, and headers
of a megabyte; beside them an operator who was served before. Exit code 1: with clients or attackers a sample was
lost, or 2 % were left out; the ratio is above 1.1; or the operator was not served. The figures mean something on a quiet machine alone. All traffic stays on 127.0.0.1.
"""
import asyncio
import collections
import json
import os
import re
import resource
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request

POLLERS, POLL_HZ, STREAMS = 50, 20.0, 20
MOST_RATIO = 1.1
SLOW, CONNECTIONS, HEADER_BYTES = 300, 5000, 1 << 20  # attackers
LEFT_OUT = 0.02  # at most so many of the samples; the rig and the clients share the service's processors
SERVED = 0.9  # of the operator's questions at least so many have an answer
PATHS = ("dwell", "channels", "health")
SETTLED_S = 10.0  # of a stretch before it counts: clients connect, caches fill


def get(port, what):
    try:
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/api/v1/{what}", timeout=10) as answer:
            return json.load(answer)
    except urllib.error.HTTPError as degraded:  # tells the same
        return json.load(degraded)


def cpu_ns(pid, name):
    """CPU time of the thread of this name."""
    for task in os.listdir(f"/proc/{pid}/task"):
        with open(f"/proc/{pid}/task/{task}/comm", encoding="ascii") as comm:
            if comm.read().strip() != name:
                continue
        with open(f"/proc/{pid}/task/{task}/schedstat", encoding="ascii") as stat:
            return int(stat.read().split()[0])
    sys.exit(f"there is no thread {name}")


def dropped_by_reason(port):
    """How many samples, by the reason."""
    reasons = collections.Counter()
    for channel in get(port, "channels")["channels"]:
        reasons.update(channel["dropped_by"])
    return reasons


def lost(reasons):
    """On the way to the estimation. What that leaves out itself, "rejected", has arrived: here readings that were answered
    more than five times later than usual, for rig, clients and service share the processors."""
    return sum(n for reason, n in reasons.items() if reason != "rejected")


async def poll(port, turn, counts):
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    try:
        due = time.monotonic() + turn / POLLERS / POLL_HZ
        while True:
            await asyncio.sleep(max(0.0, due - time.monotonic()))
            path = PATHS[turn % len(PATHS)]
            turn += 1
            writer.write(f"GET /api/v1/{path} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
            head = await reader.readuntil(b"\r\n\r\n")
            await reader.readexactly(int(re.search(rb"Content-Length: (\d+)", head)[1]))
            counts["answers"] += 1
            due = max(due + 1 / POLL_HZ, time.monotonic())
    finally:
        writer.close()


async def listen(port, query, counts):
    reader, writer = await asyncio.open_connection("127.0.0.1", port, limit=1 << 22)
    try:
        writer.write(f"GET /api/v1/stream{query} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
        while await reader.readuntil(b"\n\n"):
            counts["events"] += 1
    finally:
        writer.close()


async def clients(port, counts):
    deaf = socket.socket()  # asks for the stream and never reads
    deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    deaf.connect(("127.0.0.1", port))
    deaf.sendall(b"GET /api/v1/stream HTTP/1.1\r\nHost: localhost\r\n\r\n")
    with deaf:
        await asyncio.gather(*(poll(port, i, counts) for i in range(POLLERS)),
                             *(listen(port, "?traces" if i % 2 else "", counts) for i in range(STREAMS - 1)))


async def attack_slowly(port):
    """A request that never ends: the service closes it, and another begins."""
    while True:
        try:
            _, writer = await asyncio.open_connection("127.0.0.1", port)
            writer.write(b"GET / HTTP/1.1\r\nX: ")
            while not writer.is_closing():
                writer.write(b"a")
                await writer.drain()
                await asyncio.sleep(1.0)
        except OSError:
            await asyncio.sleep(1.0)


async def attack_with_headers(port):
    while True:
        try:
            _, writer = await asyncio.open_connection("127.0.0.1", port)
            writer.write(b"GET / HTTP/1.1\r\nX: " + b"a" * HEADER_BYTES)
            await writer.drain()
            writer.close()
        except OSError:
            pass
        await asyncio.sleep(0.05)


async def attack_with_connections(port, counts):
    """Holds as many as it can get, and asks for more whenever one is closed, 1000 a second at most."""
    held = []
    while True:
        held = [one for one in held if not one.is_closing()]
        for _ in range(min(100, CONNECTIONS - SLOW - len(held))):
            try:
                _, writer = await asyncio.open_connection("127.0.0.1", port)
                held.append(writer)
                counts["connections"] += 1
            except OSError:
                break
        await asyncio.sleep(0.1)


async def attackers(port, counts):
    operator = asyncio.ensure_future(poll(port, 0, counts))
    await asyncio.sleep(1.0)
    await asyncio.gather(operator, attack_with_headers(port), attack_with_connections(port, counts),
                         *(attack_slowly(port) for _ in range(SLOW)))


def clients_process(port, who):
    """In a process of their own, as they would be; its output is what they got."""
    counts = {"answers": 0, "events": 0, "connections": 0}
    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, CONNECTIONS + 1000), hard))

    async def until_told():
        work = asyncio.ensure_future(who(port, counts))
        asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, work.cancel)
        try:
            await work
        except asyncio.CancelledError:
            pass

    asyncio.run(until_told())
    print(json.dumps(counts))


def stretch(port, pid, seconds, who):
    """The estimation thread's share of a core, the samples dropped, and what the clients got. who: None, or an option."""
    crowd = subprocess.Popen([sys.executable, __file__, who, str(port)], stdout=subprocess.PIPE) if who else None
    time.sleep(SETTLED_S)
    earlier = dropped_by_reason(port)
    before, begun = cpu_ns(pid, "estimate"), time.monotonic()
    time.sleep(seconds)
    share = (cpu_ns(pid, "estimate") - before) / (time.monotonic() - begun) / 1e9
    not_used = dropped_by_reason(port) - earlier  # counters only grow
    got = {}
    if crowd:
        if crowd.poll() is not None:
            sys.exit("the clients have ended")
        crowd.terminate()
        got = json.loads(crowd.communicate()[0])
    return share, not_used, got


def said(process, pattern):
    for line in process.stdout:
        if match := re.search(pattern, line):
            return int(match[1])
    sys.exit(f"no {pattern}")


def main():
    build = os.path.abspath(sys.argv[1])
    pairs = int(sys.argv[2]) if len(sys.argv) > 2 else 8
    seconds = float(sys.argv[3]) if len(sys.argv) > 3 else 30.0
    rigs = os.path.join(os.path.dirname(__file__), "../../../config/rigs/clamped.toml")
    with tempfile.TemporaryDirectory() as folder, open(os.path.join(folder, "log"), "w", encoding="ascii") as log:
        rig = subprocess.Popen([os.path.join(build, "bin/rigsim"), "--tcp", "127.0.0.1:0", "--unit", "mm", "--noise", "0.001"],
                               stdout=subprocess.PIPE, stdin=subprocess.PIPE, text=True)
        with open(rigs, encoding="utf8") as sample:
            text = re.sub(r"(?m)^port .*", f"port = {said(rig, r'^tcp .*:([0-9]+)')}", sample.read())
        path = os.path.join(folder, "rig.toml")
        with open(path, "w", encoding="utf8") as file:
            file.write(re.sub(r"(?m)^listen .*", 'listen = "127.0.0.1:0"', text))
        service = subprocess.Popen([os.path.join(build, "bin/dwelld"), "--config", path, "--control", os.path.join(folder, "control")],
                                   stderr=subprocess.PIPE, text=True)
        try:
            for line in service.stderr:
                if match := re.search(r"serving rig.* port (\d+)", line):
                    port = int(match[1])
                    break
            while get(port, "dwell")["state"] != "measuring":
                time.sleep(1.0)
            ratios, answers, events, not_used = [], 0, 0, {False: collections.Counter(), True: collections.Counter()}
            for pair in range(pairs):
                # Each second pair the other way round: what drifts cancels.
                order = (False, True) if pair % 2 == 0 else (True, False)
                shares = {}
                for with_clients in order:
                    shares[with_clients], here, got = stretch(port, service.pid, seconds, "--clients" if with_clients else None)
                    not_used[with_clients] += here
                    answers += got.get("answers", 0)
                    events += got.get("events", 0)
                ratios.append(shares[True] / shares[False])
                print(f"pair {pair + 1}: {shares[False]:.4f} of a core alone, {shares[True]:.4f} with clients, "
                      f"ratio {ratios[-1]:.3f}", flush=True)
            share, not_used_attacked, got = stretch(port, service.pid, seconds, "--attackers")
            channels, health = get(port, "channels")["channels"], get(port, "health")
            under = pairs * (seconds + SETTLED_S)
            print(f"ratio, median of {pairs}: {statistics.median(ratios):.3f} ({min(ratios):.3f} … {max(ratios):.3f})")
            print(f"clients: {answers / under:.0f} answers/s of {POLLERS * POLL_HZ:.0f}, "
                  f"{events / under / (STREAMS - 1):.1f} events/s for each stream that reads; "
                  f"events dropped {health['http']['events_dropped']}")
            print(f"samples: {sum(c['received'] for c in channels)} received; lost on the way {lost(not_used[False])} alone, "
                  f"{lost(not_used[True])} with clients, {lost(not_used_attacked)} with attackers; gaps {sum(c['gaps'] for c in channels)}; "
                  f"left out by the estimation, answered too late: {not_used[False]['rejected']} alone, {not_used[True]['rejected']} with "
                  f"clients, {not_used_attacked['rejected']} with attackers")
            print(f"turns skipped {health['skipped_turns']}; load of the machine {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")
            served = got["answers"] / ((seconds + SETTLED_S) * POLL_HZ)
            print(f"attackers: {got['connections']} connections; estimation {share:.4f} of a core; an operator who was there before "
                  f"had {100 * served:.0f} % of the answers")
            received = sum(c["received"] for c in channels)
            left_out = not_used[True]["rejected"] + not_used_attacked["rejected"]
            if lost(not_used[True]) or lost(not_used_attacked) or left_out > LEFT_OUT * received or statistics.median(ratios) > MOST_RATIO or served < SERVED:
                sys.exit(1)
        finally:
            for process in (service, rig):
                process.terminate()
                process.wait()


if __name__ == "__main__":
    if sys.argv[1:2] in (["--clients"], ["--attackers"]):
        clients_process(int(sys.argv[2]), clients if sys.argv[1] == "--clients" else attackers)
    else:
        main()
