#!/bin/sh
# Whether the units let serial lines of every common kind be opened; and asks systemd whether they are well formed.
# verify_unit.sh UNIT…; exit 77: systemd cannot be asked here.
for unit in "$@"; do
  for driver in ttyS ttyUSB ttyACM ttyAMA ttymxc ttySC; do
    grep -qx "DeviceAllow=char-$driver rw" "$unit" || { echo "$unit does not allow $driver"; exit 1; }
  done
done
command -v systemd-analyze >/dev/null || { echo "skipped: systemd-analyze is not installed"; exit 77; }
scratch=$(mktemp -d) || exit 1
trap 'rm -rf "$scratch"' EXIT
status=0
for unit in "$@"; do
  name=$(basename "$unit")
  case $name in *@.service) copy=$scratch/${name%.service}bench.service ;; *) copy=$scratch/$name ;; esac
  cp "$unit" "$copy"
  said=$(systemd-analyze verify --man=no --recursive-errors=no "$copy" 2>&1) || status=1
  # What it says of other units on the host, or of a host that runs no systemd, is not about ours.
  ours=$(printf '%s\n' "$said" | grep -F "$(basename "$copy")")
  if [ -n "$ours" ]; then printf '%s\n' "$ours"; status=1; fi
  if [ $status -ne 0 ]; then printf '%s\n' "$said"; fi
done
exit $status
