#!/bin/sh
# Asks systemd whether the units are well formed. verify_unit.sh UNIT…; exit 77: cannot be asked here.
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
