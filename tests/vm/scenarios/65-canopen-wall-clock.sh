# The same where a SYNC comes back with the kernel's stamp, which goes by the wall clock.
start_can vcan0
start_rig --canopen vcan0 --noise 0.02
# Not a whole number of samples a period: else ± is mostly what harmonics that fold might do, and says nothing of noise.
canopen_rig vcan0 | sed 's/^rate = 80/rate = 83/' | start_service
of="canopen, wall clock"
. guest/wall-clock.sh
