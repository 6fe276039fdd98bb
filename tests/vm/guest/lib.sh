# What scenarios are made of. One claims something with
#   claim "the service is up" COMMAND…     ok if the command succeeds; what it printed is the reason if it does not
#   eventually SECONDS COMMAND…            succeeds once the command does, fails after the time
# and starts what it needs; tidy_up, called after each, ends all of it.
work=/tmp/dwell-vm
mkdir -p "$work"
# gojq starts ten times as fast as jq of Debian 12, which reads its own library each time: half of what a scenario cost.
jq() { gojq "$@"; }
cursor=$(journalctl -q -n 1 -o json | jq -r .__CURSOR)  # the journal counts from here on

claim() {  # NAME COMMAND…
  local name=$1 said
  shift
  if said=$("$@" 2>&1); then
    echo "ok $name"
  else
    echo "FAIL $name: $(tail -n 4 <<<"$said" | tr '\n' ' ')"
  fi
}

eventually() {  # SECONDS COMMAND…
  local end=$((SECONDS + $1)) said
  shift
  while ! said=$("$@" 2>&1); do
    [ "$SECONDS" -lt "$end" ] || { echo "$said"; return 1; }
    sleep 0.3
  done
}

# The simulated rig: rigsim with these options, serving Modbus TCP on port 1502 where nothing else is said.
start_rig() {  # OPTION…
  rm -f "$work/rig.in"
  mkfifo "$work/rig.in"
  exec 3<>"$work/rig.in"
  systemd-run -q --unit=rigsim -p StandardInput="file:$work/rig.in" /usr/local/bin/rigsim "$@"
  rigsim --print-truth "$@" >"$work/truth.json"
}
rig_says() { echo "$*" >&3; }  # a control line, such as: frequency 4.1

# dwelld as installed, with standard input as its rig file.
start_service() {
  mkdir -p /etc/dwell
  cat >/etc/dwell/rig.toml
  chmod 644 /etc/dwell/rig.toml
  systemctl reset-failed dwelld 2>/dev/null
  systemctl restart dwelld
}
# The rig that rigsim is where nothing else is said, polled and evaluated more slowly, and without the estimates from
# transients, which are most of the work: the fewer instructions, the sooner the dwell is played.
sparing='s/^update .*/update = 0.4/; s/^\[estimation\]/[verification]\nlive = false\n\n&/'
clamped_rig() { sed "s/^rate .*/rate = 80/; $sparing" /usr/share/dwell/rigs/clamped.toml; }
# The same rig on a CAN interface.
can_rig() {  # INTERFACE
  sed "$sparing; s/^interface .*/interface = \"$1\"/; s|^dbc .*|dbc = \"/usr/share/dwell/rigs/rigsim.dbc\"|" \
    /usr/share/dwell/rigs/can.toml
}
# The same with CANopen transducers; a SYNC every 12.5 ms, and answers that may take long.
canopen_rig() {  # INTERFACE
  sed "$sparing; s/^interface .*/interface = \"$1\"/; s/^rate .*/rate = 80\nrate_shift = false/" /usr/share/dwell/rigs/canopen.toml
}
property() { systemctl show dwelld -p "$1" --value; }
# Whether EXPRESSION is true of the JSON text. Nothing at all is no answer.
holds() { [ -n "$1" ] && jq -e "${@:2}" <<<"$1"; }  # JSON [OPTION…] EXPRESSION
health() {  # a jq expression that must be true of /api/v1/health
  local answer
  exec 4<>/dev/tcp/127.0.0.1/8380
  printf 'GET /api/v1/health HTTP/1.0\r\n\r\n' >&4
  answer=$(sed '1,/^\r*$/d' <&4)
  exec 4>&-
  holds "$answer" "$1" || { jq -c '[.status, .reason, .stale, .gpio]' <<<"$answer"; return 1; }
}
last_dwell() { holds "$(dwellctl dwells --json)" ".dwells[-1] | $1" || { dwellctl dwells | tail -n 4; return 1; }; }
channel() {  # NAME EXPRESSION: a jq expression that must be true of what /api/v1/channels says of it
  local said
  said=$(dwellctl channels --json | jq -c --arg name "$1" '.channels[] | select(.name == $name)')
  holds "$said" "$2" || { echo "$said"; return 1; }
}
# Faults of one kind of the first device so far.
faults() { health . | jq --arg kind "$1" '.devices[0].faults[$kind] // 0'; }
faults_reach() { [ "$(faults "$1")" -ge "$2" ] || { health . | jq -c '.devices[0].faults'; return 1; }; }
dwell_is() { holds "$(dwellctl status --json)" "$1" || { dwellctl status --json | jq -c '[.state, .warnings]'; return 1; }; }
log_of_service() { journalctl -u dwelld --no-pager --after-cursor="$cursor" "${@:--ocat}"; }  # OPTION…
log_has() { log_of_service | grep -qE -- "$1" || { log_of_service | tail -n 4; return 1; }; }

# Until the dwell holds SECONDS of data; succeeds if every coefficient is then within 4 standard uncertainties of the
# simulated rig's truth. LIMIT: seconds after which it is given up.
every_coefficient_is_right() {  # SECONDS LIMIT
  dwellctl watch --truth "$work/truth.json" --interval 1 --until "$1" --limit "$2" >"$work/watch" 2>&1 ||
    { tail -n 12 "$work/watch"; return 1; }
}

# A simulated chip of eight lines; sets $chip, its device file. A line's pull is what the outside does to it.
start_gpio() {
  local config=/sys/kernel/config/gpio-sim/dwell
  mkdir -p "$config/bank0"
  echo 8 >"$config/bank0/num_lines"
  echo 1 >"$config/live"
  chip=/dev/$(cat $config/bank0/chip_name)
  lines=/sys/devices/platform/$(cat $config/dev_name)/$(cat $config/bank0/chip_name)
  udevadm settle
}
pull() { echo "pull-$2" >"$lines/sim_gpio$1/pull"; }  # LINE up|down
level() { cat "$lines/sim_gpio$1/value"; }            # LINE

# A virtual bus for frames of up to 64 bytes.
start_can() {  # NAME
  ip link add "$1" type vcan
  ip link set "$1" mtu 72 up
}

stop_gpio() {
  local config=/sys/kernel/config/gpio-sim/dwell
  [ -d $config ] || return 0
  echo 0 >$config/live
  rmdir $config/bank0 $config
}

tidy_up() {
  systemctl stop dwelld 'dwelld@*' rigsim 2>/dev/null
  systemctl reset-failed dwelld rigsim 2>/dev/null
  umount /var/lib/dwell "$work/recorded" "$work/left" 2>/dev/null
  [ ! -e /dev/mapper/power ] || dmsetup remove power slow
  losetup -D
  clock-set synchronized -1
  rm -rf /run/systemd/system/dwelld.service.d "$work" /etc/dwell /var/lib/dwell/* /var/log/dwell/*
  systemctl daemon-reload
  stop_gpio
  ip -o link show type vcan | sed -E 's/^[0-9]+: ([^:]+):.*/\1/' | xargs -r -n 1 ip link delete
}
