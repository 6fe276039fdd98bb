# can-utils as the foreign peer, both ways: candump takes down what rigsim sends, canplayer plays it to the service; cansend
# sends single frames.
one_value() { channel "$1" ".received > 0 and (.value - $2 | fabs) < 1e-6"; }  # CHANNEL VALUE

start_can vcan0
# The player looks about once a millisecond what is due: a message waits up to one, which the rig file states for each
# channel (1 ms/√12). A millisecond is up to 2.5 % of the amplitude, and beats with the messages: the transient can be told
# to 2 % only.
can_rig vcan0 | sed 's/^tolerance .*/tolerance = 0.02/; s/^timeout .*/timeout = 2/; /^signal /a delay_u = 3e-4' | start_service
again() { cansend vcan0 "$1" && "${@:2}"; }  # FRAME COMMAND…
claim "can-utils: an integer of cansend is measured, Intel" eventually 10 again 200#40420F0000000000 one_value y0 1
claim "can-utils: a float, multiplexed, Motorola" eventually 10 again 201#003FC00000000000 one_value y1 1.5
claim "can-utils: nothing where the multiplexor says otherwise" sh -c '! cansend vcan0 201#0140000000000000 2>&1 | grep .'
claim "can-utils: the value before that stays" one_value y1 1.5
claim "can-utils: a float of a group from another address" eventually 10 again 0CFF5077#0000C84200000000 one_value reaction 100

start_can vcan1
# At a rate that is no whole number of milliseconds, nor of the drive's frequency, no message waits equally long each time.
# Noise above those beats: otherwise the service sees lines that are not the chain's, and fits them for seconds.
start_rig --can vcan1 --can-rate 83 --noise 0.1 --stopped
eventually 20 sh -c 'systemctl is-active rigsim'
candump -L vcan1 >"$work/frames.log" &
candump=$!
sleep 2
rig_says start
sleep 38
kill "$candump"
systemctl stop rigsim
claim "can-utils: candump has taken down every message" \
  test "$(cut -d' ' -f3 "$work/frames.log" | cut -d'#' -f1 | sort -u | tr '\n' ' ')" = "18FF5021 200 201 202 203 "
# It stands for a bus, which the service's work does not hold up.
chrt -f 50 canplayer -I "$work/frames.log" vcan0=vcan1 &
claim "can-utils: a log that canplayer plays is measured, every coefficient within 4 u" every_coefficient_is_right 20 120
