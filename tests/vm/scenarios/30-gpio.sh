# The GPIO lines on a simulated chip: 0 interlock, 1 sync, 2 ready lamp, 3 fault lamp (active low).
line_is() { health ".gpio.$1.$2"; }
lamp() { [ "$(level "$1")" = "$2" ] || { level "$1"; return 1; }; }
steady() {  # LINE LEVEL: for two seconds
  for _ in 1 2 3 4 5 6 7 8 9 10 11 12; do
    lamp "$1" "$2" || return 1
    sleep 0.15
  done
}
blinks() { eventually 10 lamp "$1" 1 && eventually 10 lamp "$1" 0 && eventually 10 lamp "$1" 1; }  # LINE
pulses() {  # COUNT
  for _ in $(seq "$1"); do
    echo pull-up >"$lines/sim_gpio1/pull"
    sleep 0.02
    echo pull-down >"$lines/sim_gpio1/pull"
    sleep 0.02
  done
}

start_gpio
pull 0 up
start_rig --tcp 127.0.0.1:1502 --unit mm --noise 0.001 --stopped
{
  clamped_rig
  cat <<END
[gpio]
interlock = { chip = "$chip", line = 0 }
sync      = { chip = "$chip", line = 1 }
ready     = { chip = "$chip", line = 2 }
fault     = { chip = "$chip", line = 3, active_low = true }
END
} | start_service
claim "gpio: the service's user may use the chip" line_is interlock works
claim "gpio: the interlock's level is known from the start" line_is interlock 'level == 1'
claim "gpio: the ready lamp blinks while nothing is settled" blinks 2
claim "gpio: the fault lamp is dark, high where low is active" eventually 10 lamp 3 1
rig_says start
claim "gpio: the ready lamp is steady once settled and valid" eventually 60 steady 2 1
every_coefficient_is_right 10 60 >/dev/null

pull 0 down
claim "gpio: the loss of the interlock is an event" eventually 5 log_has "the interlock is open"
claim "gpio: it shows in the health" line_is interlock 'level == 0'
claim "gpio: it has ended the dwell, which is marked" eventually 5 last_dwell '.ended_by == "interlock"'
right_at_the_end() {  # the dwell as it is kept, against the rig's truth
  dwellctl dwells --json | jq -e --slurpfile truth "$work/truth.json" '
    def off($given; $true): (($given.value - $true) / $given.u) | fabs;
    .dwells[-1].elements as $found | $truth[0] as $rig
    | [range($found | length) | off($found[.].stiffness; $rig.stiffness[.]), off($found[.].damping; $rig.damping[.])]
    | if length == 8 and max < 4 then true else "off by \(.) u" | halt_error end'
}
claim "gpio: every coefficient of it is within 4 u of the truth" right_at_the_end
claim "gpio: the operator is told why nothing is measured" sh -c 'dwellctl status | grep -q "interlock is open"'
claim "gpio: the ready lamp blinks while it is open" blinks 2
claim "gpio: nothing is measured while it is open, though the table moves" dwell_is '.state == "idle"'
pull 0 up
claim "gpio: its return is an event" eventually 5 log_has "the interlock permits"
claim "gpio: then a new dwell is measured" eventually 60 dwell_is '.state == "measuring"'

pulses 50
claim "gpio: every sync pulse is seen once" eventually 3 line_is sync 'edges == 50'
claim "gpio: none is lost" line_is sync 'lost == 0'

rig_says listen off
claim "gpio: the fault lamp is lit when the rig is off" eventually 10 lamp 3 0
rig_says listen on
claim "gpio: and dark when it is back" eventually 30 lamp 3 1

# A simulated line that is let go falls back to its pull, so the darkening is looked for in the kernel's own trace.
trace=/sys/kernel/tracing
mount -t tracefs none $trace
echo 1 >$trace/events/gpio/enable
pid=$(property MainPID)
kill -KILL "$pid"
came_back() { [ "$(property MainPID)" != "$pid" ] && [ "$(property ActiveState)" = active ]; }
claim "gpio: the service comes back after a crash" eventually 20 came_back
echo 0 >$trace/events/gpio/enable
started=$(property MainPID)
darkened() { grep -E 'dwelld-[0-9]+ ' $trace/trace | grep -v "dwelld-$started " | grep -cE "gpio_value: [0-9]+ set $1"; }
claim "gpio: in between ExecStopPost has darkened the ready lamp" darkened 0
claim "gpio: and the fault lamp, whose dark is high" darkened 1
umount $trace
claim "gpio: the lines work again" eventually 10 line_is interlock 'works and .gpio.ready.works'
