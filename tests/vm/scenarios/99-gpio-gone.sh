# A chip that is taken away under the service and comes back, maybe by another number: a link has its name, as a udev rule
# would make it. The last of all: the kernel leaves a warning of its own.
line_is() { health ".gpio.$1.$2"; }
measuring() { dwellctl status --json | jq -e '.state == "measuring"'; }

start_gpio
ln -sfn "$chip" /dev/rig-gpio
pull 0 up
start_rig --tcp 127.0.0.1:1502 --unit mm --noise 0.001
{
  clamped_rig
  echo "[gpio]"
  echo "interlock = { chip = \"/dev/rig-gpio\", line = 0 }"
  echo "ready = { chip = \"/dev/rig-gpio\", line = 2 }"
} | start_service
claim "gpio gone: the interlock works" eventually 10 line_is interlock 'level == 1'
echo 0 >/sys/kernel/config/gpio-sim/dwell/live
claim "gpio gone: the interlock counts as lost" eventually 10 log_has "the interlock is open"
claim "gpio gone: with the reason" eventually 10 line_is interlock 'works | not'
claim "gpio gone: the lamp is known not to work" eventually 10 line_is ready 'works | not'
claim "gpio gone: the service measures on" eventually 60 measuring
start_gpio
ln -sfn "$chip" /dev/rig-gpio
pull 0 up
claim "gpio gone: a chip that is back is taken again" eventually 20 line_is interlock 'works and .gpio.ready.works'
