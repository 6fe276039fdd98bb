# The rig's own sync output, one pulse for each period of the drive, on a contact that may bounce.
line_is() { health ".gpio.$1.$2"; }
seen() { health . | jq -c '[.uptime_s, .gpio.sync.edges]'; }
one_per_period() {  # of 4 Hz, between two looks at it
  jq -ne --argjson a "$1" --argjson b "$2" '($b[1] - $a[1] - 4 * ($b[0] - $a[0])) | if fabs <= 2 then true else "off by \(.) pulses" | halt_error end'
}

start_gpio
start_rig --tcp 127.0.0.1:1502 --unit mm --noise 0.001 --sync "$lines/sim_gpio1/pull"
{
  clamped_rig
  echo "[gpio]"
  echo "sync = { chip = \"$chip\", line = 1, debounce = 0.002 }"
} | start_service
claim "sync: pulses come" eventually 30 line_is sync 'edges >= 4'
first=$(seen)
sleep 10
claim "sync: one in each period of the drive" one_per_period "$first" "$(seen)"
claim "sync: none is lost" line_is sync 'lost == 0'
rig_says stop
stopped() {
  local before
  before=$(seen | jq '.[1]')
  sleep 1
  [ "$(seen | jq '.[1]')" = "$before" ]
}
claim "sync: none when the drive stops" eventually 10 stopped
