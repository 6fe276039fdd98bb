# What befalls CANopen nodes: named, counted, recovered, and the other nodes measured meanwhile.
stale() { channel "$1" ".status != \"ok\" and (.reason | test(\"$2\"))"; }  # CHANNEL REGEX
measured() { channel "$1" '.status == "ok"'; }
measuring() { measured y0 && measured y1 && measured reaction && dwell_is '.state == "measuring"'; }

start_can vcan0
start_rig --canopen vcan0 --noise 0.001
canopen_rig vcan0 | start_service
claim "canopen faults: a dwell is measured" eventually 60 measuring

rig_says node-reset 2
claim "canopen faults: a node that restarts is named" eventually 10 log_has "node 2 .*it has restarted, and is set up again"
claim "canopen faults: and measured again" eventually 90 measuring

rig_says node 2 off
claim "canopen faults: a silent node is stale, and named" eventually 10 stale y1 "node 2.*no (heartbeat|answer)"
claim "canopen faults: the others are not" measured y2
rig_says node 2 on
claim "canopen faults: measured again once it is back" eventually 90 measuring

rig_says emergency 5 16912
claim "canopen faults: an emergency is told in words" eventually 5 log_has "node 5 .*emergency 0x4210 \(device temperature\)"
claim "canopen faults: and counted" faults_reach exception 1

rig_says mapping 3 wrong
claim "canopen faults: a wrong mapping names node, object and what was found" eventually 10 \
  stale y2 "node 3.*object 6004h:00 is not mapped into any TPDO; mapped are 6030h:01"
rig_says mapping 3 right
claim "canopen faults: and is over once it is right" eventually 90 measuring

cansend vcan0 000#8004
claim "canopen faults: a node that somebody else stops is started again" eventually 10 log_has "node 4 .*it was started, and is pre-operational"
claim "canopen faults: and measured again" eventually 90 measuring

rig_says missing 0.02
rig_says late-by 0.03
rig_says late 0.02
rig_says babble 300
claim "canopen faults: late answers are counted" eventually 20 faults_reach "late answer" 5
claim "canopen faults: with answers lost and late and a node that babbles, every coefficient is within 4 u" every_coefficient_is_right 20 200
rig_says missing 0
rig_says late 0
rig_says babble 0

ip link set vcan0 down
claim "canopen faults: a link that is down is named" eventually 10 stale y0 "the link is down"
ip link set vcan0 up
claim "canopen faults: and measured again once it is up" eventually 90 measuring

rig_says bus-off
claim "canopen faults: bus-off is named" eventually 10 stale y0 "bus-off"
rig_says restart
claim "canopen faults: and measured again after the restart" eventually 90 measuring

rig_says canopen off
ip link delete vcan0
claim "canopen faults: an interface that was removed is named" eventually 15 stale y0 "removed|there is no such interface"
start_can vcan0
rig_says canopen on
claim "canopen faults: and found again once it is back" eventually 90 measuring
