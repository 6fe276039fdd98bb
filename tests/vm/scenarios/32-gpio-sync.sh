# The rig's own sync output, one pulse for each period of the drive, as the reference of a dwell: pulses that do not come, that
# come twice, and none at all. All of it is recorded, and replayed from the record.
. guest/record.sh
line_is() { health ".gpio.$1.$2"; }
seen() { health . | jq -c '[.uptime_s, .gpio.sync.edges]'; }
one_per_period() {  # of 4 Hz, between two looks at it
  jq -ne --argjson a "$1" --argjson b "$2" '($b[1] - $a[1] - 4 * ($b[0] - $a[0])) | if fabs <= 2 then true else "off by \(.) pulses" | halt_error end'
}

start_gpio
make_folder
start_rig --tcp 127.0.0.1:1502 --unit mm --noise 0.001 --sync "$lines/sim_gpio1/pull"
{
  clamped_rig | sed 's/^reference .*/reference = "sync"/'
  echo "[gpio]"
  echo "sync = { chip = \"$chip\", line = 1, debounce = 0.002 }"
  echo "fault = { chip = \"$chip\", line = 3 }"
  echo "[recording]"
} | start_service
claim "sync: pulses come" eventually 30 line_is sync 'edges >= 4'
first=$(seen)
sleep 10
claim "sync: one in each period of the drive" one_per_period "$first" "$(seen)"
claim "sync: none is lost" line_is sync 'lost == 0'
claim "sync: every coefficient of a dwell by them is within 4 u of the truth" every_coefficient_is_right 20 150
claim "sync: so is the frequency" dwell_is '.frequency_hz | (.value - 4 | fabs) < 4 * .u and .u < 0.001'

rig_says sync-missing 0.1
rig_says sync-twice 0.1
claim "sync: missed and double pulses are told" eventually 60 dwell_is \
  '.warnings | any(test("sync pulses in this hold: [1-9][0-9]* used, [1-9][0-9]* missed, [1-9][0-9]* extra"))'
claim "sync: and the coefficients are right all the same" every_coefficient_is_right 30 60

rig_says sync-missing 1
rig_says sync-twice 0
claim "sync: without pulses there is no number" eventually 20 dwell_is '.state == "fault"'
claim "sync: but a reason" sh -c 'dwellctl status | grep -q "no sync pulse for"'
claim "sync: and the fault lamp" eventually 5 test "$(level 3)" = 1
claim "sync: the dwell is marked" last_dwell '.ended_by == "data lost"'
rig_says sync-missing 0
claim "sync: with them it goes on" eventually 60 dwell_is '.state == "measuring"'

rig_says stop
stopped() {
  local before
  before=$(seen | jq '.[1]')
  sleep 1
  [ "$(seen | jq '.[1]')" = "$before" ]
}
claim "sync: none when the drive stops" eventually 10 stopped
claim "sync: the run ends with the drive" eventually 60 run 1 '.state == "closed" and .dwells >= 2'
# Its dwells begin and end with pulses, so these are in the record.
claim "sync: the replay of it is identical, pulses that missed and doubled among them" says "identical: .* bit for bit" dwellctl replay "$(file_of 1)"
