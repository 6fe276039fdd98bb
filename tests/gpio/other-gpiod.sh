#!/usr/bin/env bash
# Prints a folder with the gpiod.h of the libgpiod that this Debian does not have (1 in bookworm, 2 in trixie), fetched once by
# apt from its own sources for the other release, into a folder apart; nothing is installed. Prints nothing, and says so,
# where it cannot be had. CI compiles the code for both with it:  DWELL_OTHER_GPIOD=$(tests/gpio/other-gpiod.sh) ./dev build
set -euo pipefail
release=$(. /etc/os-release && echo "${VERSION_CODENAME:-}")
case "$release" in
  bookworm) other=trixie ;;
  trixie) other=bookworm ;;
  *) echo "other-gpiod: not known which libgpiod ${release:-this system} lacks" >&2 && exit 0 ;;
esac
folder=${XDG_CACHE_HOME:-$HOME/.cache}/dwell-gpiod/$other
[ ! -f "$folder/usr/include/gpiod.h" ] || { echo "$folder/usr/include" && exit; }

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work"/{parts,lists/partial,cache/archives/partial}
for file in /etc/apt/sources.list /etc/apt/sources.list.d/*.sources /etc/apt/sources.list.d/*.list; do
  grep -qE "^(Suites:|deb ).*[[:space:]]$release([[:space:]]|\$)" "$file" 2>/dev/null || continue
  name=$(basename "$file")
  [ "$name" != sources.list ] || name=main.list
  sed -E "s/([[:space:]])$release(-updates|-security)?\b/\1$other\2/g" "$file" >"$work/parts/$name"
done
private=(-qq -o "Dir::Etc::sourcelist=/dev/null" -o "Dir::Etc::sourceparts=$work/parts" -o "Dir::State::lists=$work/lists"
  -o "Dir::Cache=$work/cache" -o Acquire::Languages=none -o APT::Sandbox::User=)
cd "$work"
if apt-get "${private[@]}" update >&2 && apt-get "${private[@]}" download libgpiod-dev >&2; then
  mkdir -p "$folder"
  dpkg-deb -x libgpiod-dev_*.deb "$folder"
  echo "$folder/usr/include"
else
  echo "other-gpiod: libgpiod-dev of $other cannot be had here; only the installed one is compiled" >&2
fi
