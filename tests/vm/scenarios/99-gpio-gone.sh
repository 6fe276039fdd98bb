# A chip that is taken away under the service and comes back, maybe by another number: a link has its name, as a udev rule
# would make it. get.sh says what was changed in the simulated chips for it.
line_is() { health ".gpio.$1.$2"; }

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
claim "gpio gone: a dwell is measured" eventually 60 dwell_is '.state == "measuring"'
echo 0 >/sys/kernel/config/gpio-sim/dwell/live
claim "gpio gone: the interlock counts as lost" eventually 10 log_has "the interlock is open"
claim "gpio gone: with the reason" eventually 10 line_is interlock 'works | not'
claim "gpio gone: the lamp is known not to work" eventually 10 line_is ready 'works | not'
claim "gpio gone: the dwell has ended" eventually 5 last_dwell '.ended_by == "interlock"'
claim "gpio gone: nothing is measured without it" eventually 5 dwell_is '.state == "idle"'
start_gpio
ln -sfn "$chip" /dev/rig-gpio
pull 0 up
claim "gpio gone: a chip that is back is taken again" eventually 20 line_is interlock 'works and .gpio.ready.works'
claim "gpio gone: and then a dwell is measured" eventually 60 dwell_is '.state == "measuring"'
