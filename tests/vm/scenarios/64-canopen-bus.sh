# What befalls the bus itself: named, and every node set up again when it is over.
stale() { channel y0 ".status != \"ok\" and (.reason | test(\"$1\"))"; }  # REGEX
measuring() { channel y0 '.status == "ok"' && channel reaction '.status == "ok"' && dwell_is '.state == "measuring"'; }

start_can vcan0
start_rig --canopen vcan0 --noise 0.001
canopen_rig vcan0 | start_service
claim "canopen bus: a dwell is measured" eventually 60 measuring

ip link set vcan0 down
claim "canopen bus: a link that is down is named" eventually 10 stale "the link is down"
ip link set vcan0 up
claim "canopen bus: and measured again once it is up" eventually 90 measuring

rig_says bus-off
claim "canopen bus: bus-off is named" eventually 10 stale "bus-off"
rig_says restart
claim "canopen bus: and measured again after the restart" eventually 90 measuring

rig_says canopen off
ip link delete vcan0
claim "canopen bus: an interface that was removed is named" eventually 15 stale "removed|there is no such interface"
start_can vcan0
rig_says canopen on
claim "canopen bus: and found again once it is back" eventually 90 measuring
