#!/bin/bash
# In the guest, as root: installs what the host shares as a package would, then runs every scenario, each in a shell of its
# own with guest/lib.sh. Exit 0 if no line says FAIL.
cd /mnt/host || exit 1
cp -a --no-preserve=ownership root/. /
# Nothing that a scenario runs or looks for lies on the share: waiting for the host the guest's clock would leap.
cp -a --no-preserve=ownership bin/. /usr/local/bin/
systemd-sysusers
udevadm control --reload
systemctl daemon-reload
read -r up _ </proc/uptime
echo "guest: $(uname -r), up in $up s"

export PATH=/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin
failed=0 passed=0
# s that the processor was not idle for, since the guest is up: what the scenario costs the host.
busy() { awk '/^cpu / {print int(($2 + $3 + $4 + $7 + $8) / 100)}' /proc/stat; }
run() {  # NAME FILE
  local code
  timeout -k 5 240 bash -c 'set -u; . guest/lib.sh; . "$1"' "$1" "$2" 2>/tmp/errors </dev/null | tee /tmp/lines
  code=${PIPESTATUS[0]}
  {
    [ "$code" -eq 0 ] || echo "FAIL $1: it ended with $code: $(tail -n 3 /tmp/errors | tr '\n' ' ')"
    grep -qE "^(ok|FAIL) " /tmp/lines || echo "FAIL $1: it claimed nothing"
  } | tee -a /tmp/lines
  # What a scenario leaves running or changed is undone here, so that none depends on the one before.
  timeout -k 5 60 bash -c '. guest/lib.sh; tidy_up' >/dev/null 2>&1
}
for file in scenarios/*.sh; do
  name=$(basename "$file" .sh)
  [ ! -s wanted ] || grep -qx "$name" wanted || continue
  read -r began _ </proc/uptime
  busy_began=$(busy)
  run "$name" "$file"
  read -r ended _ </proc/uptime
  echo "-- $name: $((${ended%.*} - ${began%.*})) s, the processor busy for $(($(busy) - busy_began)) s; $(awk '/^processes/{print $2}' /proc/stat) processes so far"
  passed=$((passed + $(grep -c '^ok ' /tmp/lines)))
  failed=$((failed + $(grep -c '^FAIL ' /tmp/lines)))
done
echo "== $passed ok, $failed failed"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
