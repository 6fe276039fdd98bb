# A complete dwell on CANopen: nodes set up by SDO, sampled at our SYNC; candump sees both.
seen() { grep -qE "$1" "$work/frames.log" || { head -n 4 "$work/frames.log"; return 1; }; }  # a line of candump -L
# Distances between SYNCs as candump's stamps have them: their median, as where an answer is late one is left out.
period_is() {  # SECONDS
  grep -E ' 080#' "$work/frames.log" | sed -E 's/^\(([0-9.]+)\).*/\1/' | awk 'NR > 1 {print $1 - last} {last = $1}' | sort -n |
    awk -v period="$1" '{distance[NR] = $1} END {median = distance[int((NR + 1) / 2)]; print NR, median;
      exit !(NR > 100 && median > 0.99 * period && median < 1.01 * period)}'
}

start_can vcan0
start_rig --canopen vcan0 --noise 0.001
candump -L vcan0 >"$work/frames.log" &
candump=$!
sleep 1
canopen_rig vcan0 | start_service
claim "canopen: every coefficient is within 4 u of the truth" every_coefficient_is_right 20 150
kill "$candump"
claim "canopen: candump sees our NMT commands" seen ' 000#8201$'
claim "canopen: and the start" seen ' 000#0105$'
claim "canopen: and our SDO requests, the mapping read" seen ' 602#40001A02'
claim "canopen: and a disabled TPDO set to SYNC, its identifier last" seen ' 602#2F00180201'
claim "canopen: and enabled" seen ' 602#23001801820100.0$'
claim "canopen: and the heartbeat time set" seen ' 604#2B171000C800'
claim "canopen: and SYNC, at its period" period_is 0.0125
claim "canopen: and the nodes' answers to it" seen ' 185#[0-9A-F]{8}$'
claim "canopen: nothing was lost for lack of room" health '(.devices[0].faults.overflow // 0) == 0'
