#!/usr/bin/env bash
# Prints the path of promtool of this Debian, fetched once by apt into a folder apart; nothing is installed, since Debian's
# package brings a server that starts by itself. Prints nothing, and says so, where it cannot be had. CI checks the metrics
# with it:  DWELL_PROMTOOL=$(tests/daemon/promtool.sh) ./dev test
set -euo pipefail
folder=${XDG_CACHE_HOME:-$HOME/.cache}/dwell-promtool
program=$folder/usr/bin/promtool
[ ! -x "$program" ] || { echo "$program" && exit; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
if apt-get -qq -o APT::Sandbox::User= download prometheus >&2 && dpkg-deb -x prometheus_*.deb "$work/all"; then
  mkdir -p "$(dirname "$program")"
  mv all/usr/bin/promtool "$program"
  echo "$program"
else
  echo "promtool: Debian's prometheus cannot be had here; only its Python client reads the metrics" >&2
fi
