# What befalls CANopen nodes: named, counted, recovered, and the other nodes measured meanwhile.
stale() { channel "$1" ".status != \"ok\" and (.reason | test(\"$2\"))"; }  # CHANNEL REGEX
measured() { channel "$1" '.status == "ok"'; }
measuring() { measured y0 && measured y1 && measured reaction && dwell_is '.state == "measuring"'; }

start_can vcan0
start_rig --canopen vcan0 --noise 0.001
canopen_rig vcan0 | start_service
claim "canopen nodes: a dwell is measured" eventually 60 measuring

rig_says node-reset 2
claim "canopen nodes: a node that restarts is named" eventually 10 log_has "node 2 .*it has restarted, and is set up again"
claim "canopen nodes: and measured again" eventually 90 measuring

rig_says node 2 off
claim "canopen nodes: a silent node is stale, and named" eventually 10 stale y1 "node 2.*no (heartbeat|answer)"
claim "canopen nodes: the others are not" measured y2
rig_says node 2 on
claim "canopen nodes: measured again once it is back" eventually 90 measuring

rig_says emergency 5 16912
claim "canopen nodes: an emergency is told in words" eventually 5 log_has "node 5 .*emergency 0x4210 \(device temperature\)"
claim "canopen nodes: and counted" eventually 5 faults_reach exception 1

rig_says mapping 3 wrong
claim "canopen nodes: a wrong mapping names node, object and what was found" eventually 10 \
  stale y2 "node 3.*object 6004h:00 is not mapped into any TPDO; mapped are 6030h:01"
rig_says mapping 3 right
claim "canopen nodes: and is over once it is right" eventually 90 measuring

cansend vcan0 000#8004
claim "canopen nodes: a node that somebody else stops is started again" eventually 10 log_has "node 4 .*it was started, and is pre-operational"
claim "canopen nodes: and measured again" eventually 90 measuring
