# The wall clock is set and slewed while samples are stamped by a poll. Samples and simulated rig go by the raw monotonic
# clock.
start_rig --tcp 127.0.0.1:1502 --unit mm --noise 0.02
clamped_rig | start_service
of="wall clock"
. guest/wall-clock.sh
