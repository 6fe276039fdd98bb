# What befalls a service that records: it is killed amid a run, its disk stalls, and its disk fills up. Measuring goes on.
. guest/record.sh
held_up_to() { dwellctl audit "$1" --json | jq -r '.files[0].until_utc'; }
fill_the_disk() {  # until an attempt adds nothing; a few blocks may be left that the file system keeps for itself
  fallocate -l $(($(df --output=avail -B1 $folder | tail -n 1) - 1000000)) $folder/filler
  local again size before=-1
  for again in $(seq 50); do  # the recorder may free a block between two attempts
    cat /dev/zero >>$folder/filler 2>/dev/null
    sync -f $folder/filler
    size=$(stat -c %s $folder/filler)
    [ "$size" -ne "$before" ] || return 0
    before=$size
  done
  df $folder
  return 1
}
lost_since() {  # FILE UTC SECONDS
  local lost
  lost=$(($(date -d "$2" +%s%3N) - $(date -d "$(held_up_to "$1")" +%s%3N)))
  echo "$lost ms are lost"
  [ "$lost" -ge 0 ] && [ "$lost" -le $(($3 * 1000)) ]
}
stall_the_disk() {  # SECONDS; fails if something was written there meanwhile
  local touching stood=0
  fsfreeze -f $folder
  touch $folder/probe &
  touching=$!
  sleep "$1"
  kill -0 $touching || stood=$?
  fsfreeze -u $folder
  wait $touching
  rm $folder/probe
  return $stood
}

start_recorded_rig
rig_says start
claim "record faults: a run begins" eventually 40 run 1 '.state == "recording"'
sleep 5
systemctl kill -s KILL dwelld
killed=$(date -u +%Y-%m-%dT%H:%M:%S.%NZ)
claim "record faults: killed, it goes on with a new run" eventually 60 run 2 '.state == "recording" and .begun_by == "service"'
claim "record faults: the killed one is listed as cut off" eventually 20 run 1 '.state == "cut off"'
first=$(file_of 1) second=$(file_of 2)
claim "record faults: it is open, not tampered" says "${first##*/}: open until " audit "$first"
claim "record faults: it misses two seconds at most" lost_since "$first" "$killed" 2
claim "record faults: what is left of it is replayed" says "identical: " dwellctl replay "$first"

claim "record faults: a dwell is measured" eventually 60 dwell_is '.state == "measuring"'
claim "record faults: the disk stalls for 5 s" stall_the_disk 5
claim "record faults: nothing of the stream is lost" eventually 10 \
  health '.recorder | .recording and .lost_records == 0 and .lost_results == 0 and .lost_events == 0'
claim "record faults: the disk is filled" fill_the_disk
claim "record faults: recording stops with an alarm" eventually 20 health '.status == "degraded" and (.reason | test("disk full"))'
claim "record faults: and a line in the log" log_has "recording stops: disk full; measuring goes on"
claim "record faults: a start is refused with the room that is missing" eventually 10 \
  refused "recording is stopped: disk full: .*free [0-9]+ MB more there" dwellctl start --label faults
claim "record faults: the run was closed with the room kept for that" says "${second##*/}: intact$" audit "$second"
claim "record faults: it is replayed across the stall" says "identical: " dwellctl replay "$second"
claim "record faults: it says why it ended" shown "$second" 'any(.events[]; .text | test("recording stops: disk full"))'
claim "record faults: and that it went on after an interruption" shown "$second" 'any(.events[]; .text | test("goes on after an interruption"))'
claim "record faults: the dwell is measured on" every_coefficient_is_right 8 60
rm $folder/filler
claim "record faults: with room again a new run begins" eventually 60 run 3 '.state == "recording" and .begun_by == "service"'
claim "record faults: and the alarm is over" eventually 20 health '.status == "ok"'
systemctl stop dwelld
claim "record faults: each run is there, and the ledger unbroken" says "ledger: unbroken$" audit $folder/*.dwell
