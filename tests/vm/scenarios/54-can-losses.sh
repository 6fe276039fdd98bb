# Frames lost, short, late and in the way of others, during a dwell.
start_can vcan0
start_rig --can vcan0 --can-rate 80 --noise 0.001
can_rig vcan0 | start_service
measuring() { dwell_is '.state == "measuring"'; }
every_sample_is_accounted_for() {
  dwellctl channels --json | jq -e '.channels | all(.received == .used + .dropped + .queued)' || dwellctl channels
}
claim "can losses: a dwell is measured" eventually 60 measuring
rig_says missing 0.1
rig_says short 0.02
rig_says babble 500
rig_says late-by 0.002
rig_says late 0.3
claim "can losses: short frames are counted" eventually 20 faults_reach "short frame" 5
claim "can losses: with one frame of ten lost, some short, many 2 ms late and a node that babbles, every coefficient is within 4 u" \
  every_coefficient_is_right 20 150
for fault in missing short babble late; do rig_says "$fault" 0; done

# The service does not get to read for a while.
pid=$(property MainPID)
kill -STOP "$pid"
cangen vcan0 -g 0 -n 6000 -I 200 -L 8 -D 0000000000000000
kill -CONT "$pid"
claim "can losses: what the kernel had no room for is counted" eventually 10 faults_reach overflow 100
claim "can losses: and named" eventually 5 log_has "frames were lost for lack of room"
claim "can losses: of every channel received is used and dropped and queued" every_sample_is_accounted_for
claim "can losses: measured again" eventually 90 measuring

# Readings that are of another instant than their frames say cannot be told from a motion that is so: what can be claimed
# is that a dwell begun after them is right.
rig_says late-by 0.2
rig_says late 0.3
sleep 3
# Late frames give outliers. While a rig settles, its health tells of them as degraded, so the channels are asked.
claim "can losses: late frames keep no channel from delivering" \
  holds "$(dwellctl channels --json)" '.channels | length > 0 and all(.status == "ok" or .status == "gated")'
rig_says late 0
rig_says stop
claim "can losses: the drive's end is seen" eventually 20 dwell_is '.state == "idle"'
rig_says start
claim "can losses: the next dwell is right" every_coefficient_is_right 15 120
