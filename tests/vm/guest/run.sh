#!/bin/bash
# In the guest, as root: installs what the host shares as a package would, then runs every scenario, each in a shell of its
# own with guest/lib.sh. What fails is tried once more, said so: where the machine under this one was busy for a while, that
# was another rig than the one meant. Exit 0 if no line says FAIL.
cd /mnt/host || exit 1
cp -a --no-preserve=ownership root/. /
systemd-sysusers
udevadm control --reload
systemctl daemon-reload
read -r up _ </proc/uptime
echo "guest: $(uname -r), up in $up s"

export PATH=/mnt/host/bin:/usr/sbin:$PATH
failed=0 passed=0
attempt() {  # NAME FILE WORD: runs it, with WORD for FAIL; true if nothing failed
  local code
  timeout -k 5 240 bash -c 'set -u; . guest/lib.sh; . "$1"' "$1" "$2" 2>/tmp/errors </dev/null |
    sed -u "s/^FAIL /$3 /" | tee /tmp/lines
  code=${PIPESTATUS[0]}
  {
    [ "$code" -eq 0 ] || echo "$3 $1: it ended with $code: $(tail -n 3 /tmp/errors | tr '\n' ' ')"
    grep -qE "^(ok|$3) " /tmp/lines || echo "$3 $1: it claimed nothing"
  } | tee -a /tmp/lines
  # What a scenario leaves running or changed is undone here, so that none depends on the one before.
  timeout -k 5 60 bash -c '. guest/lib.sh; tidy_up' >/dev/null 2>&1
  ! grep -q "^$3 " /tmp/lines
}
for file in scenarios/*.sh; do
  name=$(basename "$file" .sh)
  [ ! -s wanted ] || grep -qx "$name" wanted || continue
  read -r began _ </proc/uptime
  attempt "$name" "$file" "not at once:" || attempt "$name" "$file" FAIL
  read -r ended _ </proc/uptime
  echo "-- $name: $((${ended%.*} - ${began%.*})) s"
  passed=$((passed + $(grep -c '^ok ' /tmp/lines)))
  failed=$((failed + $(grep -c '^FAIL ' /tmp/lines)))
done
echo "== $passed ok, $failed failed"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
