# The same where the kernel stamps the frames, which it does by the wall clock.
start_can vcan0
start_rig --can vcan0 --can-rate 83 --noise 0.02
can_rig vcan0 | start_service
of="can, wall clock"
. guest/wall-clock.sh
