#!/usr/bin/env python3
"""What the service takes at 64 channels of 10 kHz, in real time, with estimation and recording on.

service_load.py BUILD [SECONDS]

BUILD is a build folder with dwelld, dwellctl and the target dwell-driver-synthetic. Eight devices of eight channels: the
table and seven masses of a chain that is driven at 10 Hz, and 56 auxiliary channels. Prints, of the run that was
recorded: samples lost, the part of a core that each thread takes, bytes a sample, and what the audit says.
"""
import cmath
import json
import math
import os
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request

CHANNELS, DEVICES, RATE, DRIVE = 64, 8, 10_000, 10.0
MASSES = [2.0, 1.5, 2.5, 1.0, 2.0, 1.2, 0.8]
STIFFNESS, DAMPING = 40_000.0, 60.0
STEP = 1e-6  # m, of the converters


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


PORT = free_port()


def phasors():
    """Of the table (2 mm) and each mass of the free chain: the tridiagonal equations from the end on."""
    w = 2 * math.pi * DRIVE
    z = STIFFNESS + 1j * w * DAMPING
    ratios, behind = [], 0  # y_k = ratio_k y_(k-1)
    for mass in reversed(MASSES):
        ratio = z / (z - w * w * mass + behind)
        behind = z * (1 - ratio)
        ratios.append(ratio)
    y = [2e-3 + 0j]
    for ratio in reversed(ratios):
        y.append(y[-1] * ratio)
    return y


def rig(folder):
    text = f"""[rig]
name = "load"
boundary = "free"
masses = {MASSES}
[excitation]
frequency = {DRIVE}
minimum = 2e-5
[server]
listen = "127.0.0.1:{PORT}"
[recording]
directory = "{folder}/runs"
"""
    for device in range(DEVICES):
        text += f"""[[device]]
name = "d{device}"
driver = "synthetic"
rate = {RATE}
frequency = {DRIVE}
lag = {device * 11e-6}
"""
    y = phasors()
    for channel in range(CHANNELS):
        device = channel % DEVICES
        text += f'[[channel]]\nname = "x{channel}"\ndevice = "d{device}"\n'
        if channel < len(y):
            # All devices' sines run in the raw clock: the lag of a device turns nothing.
            text += (f'measures = "displacement"\nat = {channel}\nunit = "m"\nscale = {STEP}\n'
                     f"amplitude = {abs(y[channel]) / STEP:.6f}\nphase = {cmath.phase(y[channel]):.9f}\n")
        else:
            text += f'measures = "auxiliary"\nunit = "V"\namplitude = {100 * channel}.0\n'
    return text


def threads(pid):
    """CPU seconds by thread name."""
    seconds = {}
    for task in os.listdir(f"/proc/{pid}/task"):
        try:
            with open(f"/proc/{pid}/task/{task}/stat", encoding="ascii") as stat:
                line = stat.read()
        except OSError:
            continue
        name = line[line.index("(") + 1:line.rindex(")")]
        fields = line[line.rindex(")") + 2:].split()
        name = "devices" if name[0] == "d" and name[1:].isdigit() else name
        seconds[name] = seconds.get(name, 0.0) + (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return seconds


def get(what):
    try:
        with urllib.request.urlopen(f"http://127.0.0.1:{PORT}/api/v1/{what}", timeout=10) as answer:
            return json.load(answer)
    except urllib.error.HTTPError as degraded:  # tells the same
        return json.load(degraded)


def main():
    build, duration = sys.argv[1], float(sys.argv[2]) if len(sys.argv) > 2 else 300.0
    with tempfile.TemporaryDirectory(dir="/var/tmp") as folder:
        path = os.path.join(folder, "rig.toml")
        with open(path, "w", encoding="ascii") as file:
            file.write(rig(folder))
        environment = dict(os.environ, DWELL_DRIVER_PATH=os.path.join(build, "tests/load"))
        service = subprocess.Popen([os.path.join(build, "bin/dwelld"), "--config", path, "--control", os.path.join(folder, "control")],
                                   env=environment)
        try:
            time.sleep(5.0)
            if service.poll() is not None:
                sys.exit("the service has ended")
            while get("health")["recorder"]["recording"] is False:
                time.sleep(1.0)
            before, begun = threads(service.pid), time.monotonic()
            fullest = 0.0
            while time.monotonic() - begun < duration:
                time.sleep(1.0)
                fullest = max(fullest, get("health")["recorder"]["buffer_fill"])
            after, took = threads(service.pid), time.monotonic() - begun
            health, channels, dwell = get("health"), get("channels"), get("dwell")
        finally:
            service.terminate()
            service.wait()
        for name in sorted(after, key=lambda n: before.get(n, 0.0) - after[n]):
            share = (after[name] - before.get(name, 0.0)) / took
            if share >= 0.001:
                print(f"{name:12} {share:.3f} of a core")
        channels = channels["channels"]
        total = {key: sum(channel[key] for channel in channels) for key in ("received", "dropped", "gaps")}
        print(f"{took:.0f} s; samples: {total}; recorder: lost records {health['recorder']['lost_records']}, results "
              f"{health['recorder']['lost_results']}, buffer at most {fullest:.3f} full; turns skipped "
              f"{health['skipped_turns']}")
        print(f"state {dwell['state']}, elements identified {sum(e['identifiable'] for e in dwell['elements'])} of {len(MASSES)}")
        for name in os.listdir(os.path.join(folder, "runs")):
            if name.endswith(".dwell"):
                file = os.path.join(folder, "runs", name)
                audit = json.loads(subprocess.run([os.path.join(build, "bin/dwellctl"), "audit", "--json", file],
                                                  capture_output=True, check=False).stdout)["files"][0]
                print(f"{name}: {audit['state']}, {audit['samples']} samples, "
                      f"{os.path.getsize(file) / max(audit['samples'], 1):.2f} bytes each")


if __name__ == "__main__":
    main()
