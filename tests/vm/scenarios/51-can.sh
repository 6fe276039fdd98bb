# A complete dwell on CAN: Intel, Motorola and multiplexed floats, a J1939 message; and what the kernel keeps from us.
filters_are_set() {  # the kernel's own lists: four identifiers, one group of any source, priority and page
  local exact masked
  exact=$(grep -cE '^ *vcan0 +20[0-3] +c00007ff' /proc/net/can/rcvlist_sff)
  masked=$(grep -ciE '^ *vcan0 +80ff5000 +c3ffff00|^ *vcan0 +98ff5000 +c3ffff00' /proc/net/can/rcvlist_fil)
  [ "$exact" = 4 ] && [ "$masked" = 1 ] || { grep vcan0 /proc/net/can/rcvlist_*; return 1; }
}

start_can vcan0
start_rig --can vcan0 --can-rate 80 --noise 0.001
can_rig vcan0 | start_service
claim "can: the kernel is asked for the identifiers in use alone" eventually 20 filters_are_set
claim "can: every coefficient is within 4 u of the truth" every_coefficient_is_right 20 150
claim "can: nothing was lost" health '(.devices[0].faults.overflow // 0) == 0'
claim "can: the frames carry the kernel's stamps" channel y0 '.latency_s == null or .latency_s < 0.001'
