# Lines that cannot be had, and the keys of a line: 0 interlock (held by another program at first), 1 sync on a chip that is
# not there, 2 ready lamp on a line that the chip does not have.
line_is() { health ".gpio.$1.$2"; }

start_gpio
start_rig --tcp 127.0.0.1:1502 --unit mm --noise 0.001
gpioset --mode=signal "$(basename "$chip")" 0=0 &
holder=$!
held() { gpioinfo "$(basename "$chip")" | grep -q 'line *0:.*gpioset'; }
eventually 10 held
{
  clamped_rig
  cat <<END
[gpio]
interlock = { chip = "$chip", line = 0, bias = "pull-up", debounce = 0.02 }
sync      = { chip = "/dev/gpiochip99", line = 1 }
ready     = { chip = "$chip", line = 200 }
fault     = { chip = "$chip", line = 3 }
END
} | start_service
claim "gpio fault: a line in use is told with its holder" line_is interlock 'reason | test("in use by .gpioset")'
claim "gpio fault: an absent chip is told" line_is sync 'reason == "there is no /dev/gpiochip99"'
claim "gpio fault: a line that is not there is told" line_is ready 'reason | test("there is no line 200 of /dev/gpiochip")'
claim "gpio fault: so it is in the log" log_has "interlock does not work: line 0 of .* is in use"
claim "gpio fault: the operator sees it" sh -c 'dwellctl status | grep -q "sync does not work: there is no"'
claim "gpio fault: the health is degraded" health '.status == "degraded"'
claim "gpio fault: the fault lamp is lit" eventually 10 test "$(level 3)" = 1
claim "gpio fault: the service measures all the same" eventually 60 dwell_is '.state == "measuring"'

kill "$holder"
claim "gpio fault: a line that is let go is taken" eventually 20 line_is interlock works
claim "gpio fault: the chip's own pull-up is set" eventually 5 line_is interlock 'level == 1'
pull 0 down
claim "gpio fault: with debounce the loss is seen as well" eventually 5 line_is interlock 'level == 0'
pull 0 up
claim "gpio fault: and the return" eventually 5 line_is interlock 'level == 1'
