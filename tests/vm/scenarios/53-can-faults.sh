# What befalls a bus: counted, named, recovered. vcan has no bit rate, no arbitration and no controller: bus-off and
# error-passive are error frames here, sent by rigsim and by cansend, which the kernel hands on like a controller's.
stale() { channel y0 ".status != \"ok\" and (.reason | test(\"$1\"))" && channel reaction '.status != "ok"'; }
measuring() { channel y0 '.status == "ok"' && dwell_is '.state == "measuring"'; }

start_can vcan0
start_rig --can vcan0 --can-rate 80 --noise 0.001
can_rig vcan0 | start_service
claim "can faults: a dwell is measured" eventually 60 measuring

ip link set vcan0 down
claim "can faults: a link that is down is named" eventually 10 stale "the link is down"
ip link set vcan0 up
claim "can faults: and measured again once it is up" eventually 90 measuring
claim "can faults: it was counted" faults_reach disconnected 1

rig_says bus-off
claim "can faults: bus-off is named" eventually 10 stale "bus-off"
rig_says restart
claim "can faults: and over with the restart" eventually 90 measuring
claim "can faults: it was counted" faults_reach "bus off" 1
claim "can faults: the restart is in the log" log_has "the controller was restarted"

rig_says silent on
claim "can faults: frames that stay away are named" eventually 10 stale "no frame for 0.5 s"
cansend vcan0 20000004#0010000000000000
claim "can faults: error-passive is named" eventually 5 log_has "the controller is error-passive"
cansend vcan0 20000040#0000000000000000
claim "can faults: bus-off by an error frame of cansend" eventually 5 stale "bus-off"
cansend vcan0 20000100#0000000000000000
claim "can faults: its restart without a frame blames the frames" eventually 5 stale "no frame for"
rig_says silent off
claim "can faults: measured again" eventually 90 measuring

rig_says can off
ip link delete vcan0
claim "can faults: an interface that was removed is named" eventually 15 stale "removed|there is no such interface"
start_can vcan0
rig_says can on
claim "can faults: and found again once it is back" eventually 90 measuring
