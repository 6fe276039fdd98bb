# dwelld under systemd as installed: it gets ready, tells how it stands, is killed by the watchdog and comes back, under
# the user and with the rights that the unit says.
status_says() { property StatusText | grep -E -- "$1" || { property StatusText; return 1; }; }
journal_field() { log_of_service -ojson | jq -es "any(.$1 == \"$2\")"; }
# systemd forgets the unit with its times, so the clock is asked before and after.
uptime_ms() { awk '{ printf "%.0f", $1 * 1000 }' /proc/uptime; }
stops_within_a_second() {
  local asked_ms took_ms
  asked_ms=$(uptime_ms)
  systemctl stop dwelld || return 1
  took_ms=$(($(uptime_ms) - asked_ms))
  echo "took $took_ms ms"
  [ "$took_ms" -lt 1000 ]
}
restarts() { [ "$(property NRestarts)" -ge "$1" ] || { property NRestarts; return 1; }; }

start_rig --tcp 127.0.0.1:1502 --unit mm --noise 0.001
clamped_rig >"$work/rig.toml"
claim "service: starts and says that it is ready" start_service <"$work/rig.toml"
claim "service: tells systemd its state" eventually 60 status_says "settling|measuring"
claim "service: the operator reaches it over HTTP" health '.status == "ok"'
claim "service: runs as its own user" test "$(ps -o user= -p "$(property MainPID)")" = dwell
claim "service: has no capability" grep -q '^CapEff:\s*0*$' "/proc/$(property MainPID)/status"
claim "service: states are fields in the journal" eventually 60 journal_field DWELL_STATE measuring

pid=$(property MainPID)
kill -STOP "$pid"
claim "service: the watchdog kills it when it hangs" eventually 30 log_has "watchdog|Watchdog"
claim "service: it comes back by itself" eventually 20 restarts 1
claim "service: and measures again" eventually 60 status_says "measuring"
claim "service: stops within a second" stops_within_a_second
claim "service: with success" test "$(property Result)" = success

start_service <<<"[rig" 2>/dev/null
claim "service: a broken rig file is not tried again and again" test "$(property NRestarts)" = 0
claim "service: and is answered with its place" eventually 5 log_has "rig.toml:1:"
