# The same where a SYNC comes back with the kernel's stamp, which goes by the wall clock.
start_can vcan0
start_rig --canopen vcan0 --noise 0.02
canopen_rig vcan0 | start_service
of="canopen, wall clock"
. guest/wall-clock.sh
